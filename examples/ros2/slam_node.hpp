/// ssjs::online as a ROS 2 node. Written after the interfaces of ROS 2 Humble and Jazzy; docs/embedding.md says what it was tried with.
///
/// Listens to (all body vectors in base_link, REP 103; what a vehicle does not have stays silent):
///   imu        sensor_msgs/Imu: turn rates; roll, pitch and heading where the message has an orientation (REP 145: against north-aligned
///   ENU) pressure   sensor_msgs/FluidPressure: absolute dvl        geometry_msgs/TwistWithCovarianceStamped: over ground; a negative first
///   variance means no bottom lock altitude   sensor_msgs/Range: straight down sightings  geometry_msgs/PointStamped: points on the seabed,
///   as detectors find them
///   fix        sensor_msgs/NavSatFix: against the origin of the parameters, where satellites are to be used; the map is north-aligned
///              then (setting joining.north_offset_rad)
/// Publishes odometry (nav_msgs/Odometry, pose of base_link in map, no twist), the transform map -> base_link, /diagnostics.
/// One executor thread: an Estimator belongs to one thread at a time.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <tf2_ros/transform_broadcaster.h>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/point_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <geometry_msgs/msg/twist_with_covariance_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/fluid_pressure.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/nav_sat_fix.hpp>
#include <sensor_msgs/msg/range.hpp>

#include "frames.hpp"
#include "ssjs/embed/online.hpp"

namespace ssjs_ros {

using ssjs::online::Estimator;
using ssjs::online::Health;

/// "key=text" each, keys of `ssjs-cli config dump --of underwater`.
inline Estimator estimator_with(const std::vector<std::string>& settings) {
  std::vector<std::pair<std::string, std::string>> parts;
  for (const std::string& setting : settings) {
    const std::size_t sign = setting.find('=');
    parts.emplace_back(setting.substr(0, sign), sign == std::string::npos ? "" : setting.substr(sign + 1));
  }
  std::vector<ssjs::online::Setting> list;
  for (const auto& [key, text] : parts) list.push_back({key.c_str(), text.c_str()});
  return Estimator(list.data(), list.size());
}

class SlamNode : public rclcpp::Node {
 public:
  SlamNode()
      : Node("ssjs"),
        estimator_(estimator_with(declare_parameter("settings", std::vector<std::string>{}))),
        map_(declare_parameter("map_frame", std::string("map"))),
        base_(declare_parameter("base_frame", std::string("base_link"))),
        surface_pa_(declare_parameter("surface_pressure_pa", 101325.0)),
        density_(declare_parameter("water_density_kg_m3", 1025.0)),
        origin_deg_(declare_parameter("origin_latitude_longitude_deg", std::vector<double>{})),
        transforms_(*this) {
    const rclcpp::SensorDataQoS sensor;
    imu_ = create_subscription<sensor_msgs::msg::Imu>("imu", sensor, [this](const sensor_msgs::msg::Imu& m) { take(m); });
    pressure_ = create_subscription<sensor_msgs::msg::FluidPressure>("pressure", sensor, [this](const sensor_msgs::msg::FluidPressure& m) {
      (void)estimator_.feed(ssjs::online::Depth{seconds(m), depth_of(m.fluid_pressure, surface_pa_, density_)});
    });
    dvl_ = create_subscription<geometry_msgs::msg::TwistWithCovarianceStamped>(
        "dvl", sensor, [this](const geometry_msgs::msg::TwistWithCovarianceStamped& m) { take(m); });
    altitude_ = create_subscription<sensor_msgs::msg::Range>("altitude", sensor, [this](const sensor_msgs::msg::Range& m) { take(m); });
    sightings_ = create_subscription<geometry_msgs::msg::PointStamped>("sightings", sensor,
                                                                       [this](const geometry_msgs::msg::PointStamped& m) { take(m); });
    if (origin_deg_.size() == 2) {
      fix_ = create_subscription<sensor_msgs::msg::NavSatFix>("fix", sensor, [this](const sensor_msgs::msg::NavSatFix& m) { take(m); });
    }
    odometry_ = create_publisher<nav_msgs::msg::Odometry>("odometry", rclcpp::QoS(10));
    diagnostics_ = create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", rclcpp::QoS(10));
    pose_timer_ = create_wall_timer(std::chrono::milliseconds(100), [this] { publish_pose(); });
    status_timer_ = create_wall_timer(std::chrono::seconds(1), [this] { publish_status(); });
  }

 private:
  template <class Message>
  static double seconds(const Message& m) {
    return static_cast<double>(m.header.stamp.sec) + 1e-9 * static_cast<double>(m.header.stamp.nanosec);
  }

  void take(const sensor_msgs::msg::Imu& m) {
    const double time_s = seconds(m);
    const Vector rates = other_body({m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z});
    (void)estimator_.feed(ssjs::online::Gyro{time_s, {rates[0], rates[1], rates[2]}});
    if (m.orientation_covariance[0] < 0.0) return;  // no orientation in the message
    const Angles angles = other_angles(angles_of({m.orientation.w, m.orientation.x, m.orientation.y, m.orientation.z}));
    (void)estimator_.feed(ssjs::online::Attitude{time_s, angles.roll, angles.pitch});
    (void)estimator_.feed(ssjs::online::Compass{time_s, angles.yaw});
  }

  void take(const geometry_msgs::msg::TwistWithCovarianceStamped& m) {
    const auto& v = m.twist.twist.linear;
    const Vector velocity = other_body({v.x, v.y, v.z});
    const bool lock = m.twist.covariance[0] >= 0.0 && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    (void)estimator_.feed(ssjs::online::Velocity{seconds(m), {velocity[0], velocity[1], velocity[2]}, lock});
  }

  void take(const sensor_msgs::msg::Range& m) {
    const double range_m = m.range;
    if (!(range_m >= m.min_range && range_m <= m.max_range)) return;  // REP 117: infinite or NaN is no measurement
    (void)estimator_.feed(ssjs::online::Altitude{seconds(m), range_m});
  }

  void take(const geometry_msgs::msg::PointStamped& m) {
    const Vector point = other_body({m.point.x, m.point.y, m.point.z});
    (void)estimator_.feed(ssjs::online::Sighting{seconds(m), {point[0], point[1], point[2]}, false, {}, -1});
  }

  void take(const sensor_msgs::msg::NavSatFix& m) {
    const bool is_known = m.position_covariance_type != sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_UNKNOWN;
    if (m.status.status < sensor_msgs::msg::NavSatStatus::STATUS_FIX || !is_known) return;
    const auto& P = m.position_covariance;  // east, north, up
    const std::array<double, 2> at = north_east(m.latitude, m.longitude, origin_deg_[0], origin_deg_[1]);
    (void)estimator_.feed(ssjs::online::Fix{seconds(m), at[0], at[1], {P[4], P[1], P[1], P[0]}, false});
  }

  void publish_pose() {
    ssjs::online::Pose pose{};
    if (!estimator_.pose(&pose)) return;
    const Vector position = other_world({pose.x_m, pose.y_m, pose.z_m});
    const Quaternion q = quaternion_of(other_angles({pose.roll_rad, pose.pitch_rad, pose.yaw_rad}));
    Covariance covariance{};
    for (std::size_t i = 0; i < covariance.size(); ++i) covariance[i] = pose.covariance[i];

    nav_msgs::msg::Odometry odometry;
    odometry.header.stamp = rclcpp::Time(static_cast<std::int64_t>(std::llround(pose.time_s * 1e9)));
    odometry.header.frame_id = map_;
    odometry.child_frame_id = base_;
    odometry.pose.pose.position.x = position[0];
    odometry.pose.pose.position.y = position[1];
    odometry.pose.pose.position.z = position[2];
    odometry.pose.pose.orientation.w = q.w;
    odometry.pose.pose.orientation.x = q.x;
    odometry.pose.pose.orientation.y = q.y;
    odometry.pose.pose.orientation.z = q.z;
    odometry.pose.covariance = other_covariance(covariance);
    for (std::size_t i = 0; i < 6; ++i) odometry.twist.covariance[7 * i] = 1e6;  // the twist is not estimated here
    odometry_->publish(odometry);

    geometry_msgs::msg::TransformStamped transform;
    transform.header = odometry.header;
    transform.child_frame_id = base_;
    transform.transform.translation.x = position[0];
    transform.transform.translation.y = position[1];
    transform.transform.translation.z = position[2];
    transform.transform.rotation = odometry.pose.pose.orientation;
    transforms_.sendTransform(transform);
  }

  void publish_status() {
    using diagnostic_msgs::msg::DiagnosticStatus;
    const ssjs::online::Status now = estimator_.status();
    DiagnosticStatus status;
    status.name = "ssjs: position";
    switch (now.health) {
      case Health::kGood:
        status.level = DiagnosticStatus::OK;
        status.message = "good";
        break;
      case Health::kLost:
        status.level = DiagnosticStatus::ERROR;
        status.message = "lost";
        break;
      case Health::kWaiting:
        status.level = DiagnosticStatus::STALE;
        status.message = "nothing heard yet";
        break;
      default:
        status.level = DiagnosticStatus::WARN;
        status.message = now.advice;
    }
    const auto add = [&](const std::string& key, const auto& value) {
      diagnostic_msgs::msg::KeyValue entry;
      entry.key = key;
      entry.value = std::to_string(value);
      status.values.push_back(entry);
    };
    add("position sigma (m)", now.position_sigma_m);
    add("submaps", now.submaps);
    add("loop closures", now.loop_closures);
    const char* const sensors[] = {"attitude", "compass", "depth", "altitude", "velocity", "sighting", "fix", "gyro"};
    for (std::size_t i = 0; i < ssjs::online::kSensors; ++i) {
      add(std::string(sensors[i]) + " silent for (s)", now.silent_for_s[i]);
      add(std::string(sensors[i]) + " refused", now.refused[i]);
    }
    diagnostic_msgs::msg::DiagnosticArray array;
    array.header.stamp = this->now();
    array.status.push_back(status);
    diagnostics_->publish(array);
  }

  Estimator estimator_;
  std::string map_, base_;
  double surface_pa_, density_;
  std::vector<double> origin_deg_;
  tf2_ros::TransformBroadcaster transforms_;
  rclcpp::Subscription<sensor_msgs::msg::Imu>::SharedPtr imu_;
  rclcpp::Subscription<sensor_msgs::msg::FluidPressure>::SharedPtr pressure_;
  rclcpp::Subscription<geometry_msgs::msg::TwistWithCovarianceStamped>::SharedPtr dvl_;
  rclcpp::Subscription<sensor_msgs::msg::Range>::SharedPtr altitude_;
  rclcpp::Subscription<geometry_msgs::msg::PointStamped>::SharedPtr sightings_;
  rclcpp::Subscription<sensor_msgs::msg::NavSatFix>::SharedPtr fix_;
  rclcpp::Publisher<nav_msgs::msg::Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::TimerBase::SharedPtr pose_timer_, status_timer_;
};

}  // namespace ssjs_ros
