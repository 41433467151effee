/// Stand-ins for the ROS 2 messages that examples/ros2 uses: their fields by the message definitions, nothing else. They show that the node
/// does what it means, not that it fits ROS.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace std_msgs::msg {
struct Stamp {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
struct Header {
  Stamp stamp;
  std::string frame_id;
};
}  // namespace std_msgs::msg

namespace geometry_msgs::msg {
struct Vector3 {
  double x = 0.0, y = 0.0, z = 0.0;
};
using Point = Vector3;
struct Quaternion {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
};
struct Pose {
  Point position;
  Quaternion orientation;
};
struct Twist {
  Vector3 linear, angular;
};
struct PoseWithCovariance {
  Pose pose;
  std::array<double, 36> covariance{};
};
struct TwistWithCovariance {
  Twist twist;
  std::array<double, 36> covariance{};
};
struct TwistWithCovarianceStamped {
  std_msgs::msg::Header header;
  TwistWithCovariance twist;
};
struct PointStamped {
  std_msgs::msg::Header header;
  Point point;
};
struct Transform {
  Vector3 translation;
  Quaternion rotation;
};
struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};
}  // namespace geometry_msgs::msg

namespace sensor_msgs::msg {
struct Imu {
  std_msgs::msg::Header header;
  geometry_msgs::msg::Quaternion orientation;
  std::array<double, 9> orientation_covariance{};
  geometry_msgs::msg::Vector3 angular_velocity;
};
struct FluidPressure {
  std_msgs::msg::Header header;
  double fluid_pressure = 0.0, variance = 0.0;
};
struct NavSatStatus {
  static constexpr std::int8_t STATUS_NO_FIX = -1, STATUS_FIX = 0;
  std::int8_t status = STATUS_NO_FIX;
};
struct NavSatFix {
  static constexpr std::uint8_t COVARIANCE_TYPE_UNKNOWN = 0, COVARIANCE_TYPE_KNOWN = 3;
  std_msgs::msg::Header header;
  NavSatStatus status;
  double latitude = 0.0, longitude = 0.0, altitude = 0.0;
  std::array<double, 9> position_covariance{};
  std::uint8_t position_covariance_type = COVARIANCE_TYPE_UNKNOWN;
};
struct Range {
  std_msgs::msg::Header header;
  float min_range = 0.0F, max_range = 0.0F, range = 0.0F;
};
}  // namespace sensor_msgs::msg

namespace nav_msgs::msg {
struct Odometry {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  geometry_msgs::msg::PoseWithCovariance pose;
  geometry_msgs::msg::TwistWithCovariance twist;
};
}  // namespace nav_msgs::msg

namespace diagnostic_msgs::msg {
struct KeyValue {
  std::string key, value;
};
struct DiagnosticStatus {
  static constexpr unsigned char OK = 0, WARN = 1, ERROR = 2, STALE = 3;
  unsigned char level = 0;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
};
struct DiagnosticArray {
  std_msgs::msg::Header header;
  std::vector<DiagnosticStatus> status;
};
}  // namespace diagnostic_msgs::msg
