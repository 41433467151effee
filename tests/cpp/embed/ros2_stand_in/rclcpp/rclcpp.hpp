/// Stand-in for the part of rclcpp that examples/ros2 uses. Everything that is subscribed, published or timed is open to the test.
#pragma once

#include <any>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../messages.hpp"

namespace rclcpp {

struct QoS {
  explicit QoS(std::size_t) {}
};
struct SensorDataQoS : QoS {
  SensorDataQoS() : QoS(5) {}
};

class Time {
 public:
  explicit Time(std::int64_t nanoseconds = 0) : nanoseconds_(nanoseconds) {}
  operator std_msgs::msg::Stamp() const {  // NOLINT(google-explicit-constructor): as in rclcpp
    return {static_cast<std::int32_t>(nanoseconds_ / 1000000000), static_cast<std::uint32_t>(nanoseconds_ % 1000000000)};
  }

 private:
  std::int64_t nanoseconds_;
};

template <class Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(const Message&)> callback;
};
template <class Message>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  std::vector<Message> published;
  void publish(const Message& message) { published.push_back(message); }
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  std::function<void()> callback;
};

class Node {
 public:
  explicit Node(const std::string&) {}
  inline static std::map<std::string, std::any> overrides;  // as from a parameter file

  template <class Value>
  Value declare_parameter(const std::string& name, const Value& otherwise) {
    const auto found = overrides.find(name);
    return found == overrides.end() ? otherwise : std::any_cast<Value>(found->second);
  }
  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, const QoS&, Callback callback) {
    auto made = std::make_shared<Subscription<Message>>(Subscription<Message>{callback});
    topics[topic] = made;
    return made;
  }
  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, const QoS&) {
    auto made = std::make_shared<Publisher<Message>>();
    topics[topic] = made;
    return made;
  }
  template <class Duration>
  TimerBase::SharedPtr create_wall_timer(Duration, std::function<void()> callback) {
    timers.push_back(std::make_shared<TimerBase>(TimerBase{std::move(callback)}));
    return timers.back();
  }
  [[nodiscard]] Time now() const { return Time{}; }

  std::map<std::string, std::any> topics;
  std::vector<TimerBase::SharedPtr> timers;
};

}  // namespace rclcpp
