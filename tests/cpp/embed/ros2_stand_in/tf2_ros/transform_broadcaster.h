#pragma once
#include <vector>

#include "../messages.hpp"

namespace tf2_ros {

class TransformBroadcaster {
 public:
  template <class Node>
  explicit TransformBroadcaster(Node&) {}
  void sendTransform(const geometry_msgs::msg::TransformStamped& transform) { sent.push_back(transform); }  // NOLINT: as in tf2_ros
  inline static std::vector<geometry_msgs::msg::TransformStamped> sent;
};

}  // namespace tf2_ros
