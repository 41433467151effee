// The example node for ROS 2 against stand-ins of ROS (ros2_stand_in): frames, signs and what is fed. Never against ROS itself.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "slam_node.hpp"

namespace ssjs_ros {
namespace {

Eigen::Matrix3d rotation(const Angles& a) {
  return (Eigen::AngleAxisd(a.yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(a.pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(a.roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

TEST(RosFramesTest, AnglesAreThoseOfTheSameRotationInTheOtherFrames) {
  Eigen::Matrix3d enu_R_ned;
  enu_R_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Eigen::Matrix3d frd_R_flu = Eigen::Vector3d(1, -1, -1).asDiagonal();
  for (const Angles& a : {Angles{0.1, 0.2, 0.3}, Angles{-0.4, -1.2, 3.0}, Angles{2.0, 0.7, -2.5}}) {
    const Angles ros = other_angles(a);
    EXPECT_LT((enu_R_ned * rotation(a) * frd_R_flu - rotation(ros)).norm(), 1e-12);
    const Angles back = other_angles(ros);
    EXPECT_LT((rotation(back) - rotation(a)).norm(), 1e-12);
  }
}

TEST(RosFramesTest, QuaternionsAreThoseOfEigenAndComeBack) {
  for (const Angles& a : {Angles{0.1, 0.2, 0.3}, Angles{-0.4, -1.2, 3.0}, Angles{2.0, 0.7, -2.5}}) {
    const Quaternion q = quaternion_of(a);
    EXPECT_LT((Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix() - rotation(a)).norm(), 1e-12);
    const Angles back = angles_of(q);
    EXPECT_NEAR(back.roll, a.roll, 1e-12);
    EXPECT_NEAR(back.pitch, a.pitch, 1e-12);
    EXPECT_NEAR(back.yaw, a.yaw, 1e-12);
  }
  EXPECT_DOUBLE_EQ(angles_of(quaternion_of({0.0, 0.5 * kPi, 0.0})).pitch, 0.5 * kPi);
}

TEST(RosFramesTest, CovariancesMoveByTheJacobianOfThePose) {
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> P;
  for (Eigen::Index i = 0; i < 6; ++i) {
    for (Eigen::Index j = 0; j < 6; ++j) P(i, j) = static_cast<double>(1 + 7 * std::min(i, j) + std::max(i, j));
  }
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J(0, 1) = J(1, 0) = J(3, 3) = 1.0;
  J(2, 2) = J(4, 4) = J(5, 5) = -1.0;
  Covariance flat{};
  std::copy_n(P.data(), 36, flat.begin());
  const Covariance moved = other_covariance(flat);
  EXPECT_EQ((Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(moved.data())), J * P * J.transpose());
}

TEST(RosFramesTest, DepthIsTheWeightOfTheWaterAbove) {
  EXPECT_NEAR(depth_of(101325.0 + 1025.0 * 9.80665 * 12.0, 101325.0, 1025.0), 12.0, 1e-9);
}

/// A minute of latitude at 45 degrees is 1852.2 m on WGS 84 (111131.745 m a degree), a degree of longitude there 78846.8 m.
TEST(RosFramesTest, DegreesAreMetresOfWgs84) {
  EXPECT_NEAR(north_east(45.0 + 1.0 / 60.0, 10.0, 45.0, 10.0)[0], 111131.745 / 60.0, 0.2);
  EXPECT_NEAR(north_east(45.0, -179.99, 45.0, 179.99)[1], 0.02 * 78846.8, 0.1);  // across the date line
}

template <class Message>
auto& subscribed(SlamNode& node, const std::string& topic) {
  return *std::any_cast<typename rclcpp::Subscription<Message>::SharedPtr>(node.topics.at(topic));
}
template <class Message>
const std::vector<Message>& published(SlamNode& node, const std::string& topic) {
  return std::any_cast<typename rclcpp::Publisher<Message>::SharedPtr>(node.topics.at(topic))->published;
}

/// A vehicle that goes north at 1.5 m/s, 12 m deep, for a minute: in ROS's world along +y, at z = -12, its yaw a quarter turn.
TEST(RosNodeTest, AVehicleThatGoesNorthGoesAlongY) {
  rclcpp::Node::overrides["settings"] = std::vector<std::string>{"arrival.window_s=0.2", "joining.north_offset_rad=0"};
  tf2_ros::TransformBroadcaster::sent.clear();
  SlamNode node;
  node.timers.at(0)->callback();
  EXPECT_TRUE(published<nav_msgs::msg::Odometry>(node, "odometry").empty());  // nothing heard, nothing said

  const Quaternion north = quaternion_of({0.0, 0.0, 0.5 * kPi});
  for (int i = 0; i < 600; ++i) {
    std_msgs::msg::Header header;
    header.stamp.sec = 1700000000 + i / 10;
    header.stamp.nanosec = static_cast<std::uint32_t>(i % 10) * 100000000U;
    sensor_msgs::msg::Imu imu;
    imu.header = header;
    imu.orientation = {north.x, north.y, north.z, north.w};
    subscribed<sensor_msgs::msg::Imu>(node, "imu").callback(imu);
    sensor_msgs::msg::FluidPressure pressure;
    pressure.header = header;
    pressure.fluid_pressure = 101325.0 + 1025.0 * 9.80665 * 12.0;
    subscribed<sensor_msgs::msg::FluidPressure>(node, "pressure").callback(pressure);
    geometry_msgs::msg::TwistWithCovarianceStamped dvl;
    dvl.header = header;
    dvl.twist.twist.linear.x = 1.5;
    subscribed<geometry_msgs::msg::TwistWithCovarianceStamped>(node, "dvl").callback(dvl);
    sensor_msgs::msg::Range altitude;
    altitude.header = header;
    altitude.min_range = 0.1F;
    altitude.max_range = 50.0F;
    altitude.range = i == 300 ? INFINITY : 4.0F;
    subscribed<sensor_msgs::msg::Range>(node, "altitude").callback(altitude);
    if (i % 10 == 0) node.timers.at(0)->callback();
  }
  node.timers.at(0)->callback();
  node.timers.at(1)->callback();

  const nav_msgs::msg::Odometry& last = published<nav_msgs::msg::Odometry>(node, "odometry").back();
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_EQ(last.child_frame_id, "base_link");
  EXPECT_EQ(last.header.stamp.sec, 1700000059);
  const double sigma_m = std::sqrt(last.pose.covariance[7]);
  EXPECT_NEAR(last.pose.pose.position.y, 1.5 * 59.9, 3.0 * sigma_m + 0.1);
  EXPECT_NEAR(last.pose.pose.position.x, 0.0, 3.0 * std::sqrt(last.pose.covariance[0]) + 0.1);
  EXPECT_NEAR(last.pose.pose.position.z, -12.0, 0.2);
  EXPECT_NEAR(
      angles_of({last.pose.pose.orientation.w, last.pose.pose.orientation.x, last.pose.pose.orientation.y, last.pose.pose.orientation.z})
          .yaw,
      0.5 * kPi, 0.1);
  ASSERT_FALSE(tf2_ros::TransformBroadcaster::sent.empty());
  EXPECT_EQ(tf2_ros::TransformBroadcaster::sent.back().transform.translation.y, last.pose.pose.position.y);

  using diagnostic_msgs::msg::DiagnosticStatus;
  const auto& status = published<diagnostic_msgs::msg::DiagnosticArray>(node, "/diagnostics").back().status.at(0);
  EXPECT_EQ(status.level, DiagnosticStatus::OK) << status.message;
}

TEST(RosNodeTest, FixesArriveOnlyWithAnOriginAndACovariance) {
  rclcpp::Node::overrides["settings"] = std::vector<std::string>{"arrival.window_s=0.2", "joining.north_offset_rad=0"};
  EXPECT_EQ(SlamNode().topics.count("fix"), 0U);
  rclcpp::Node::overrides["origin_latitude_longitude_deg"] = std::vector<double>{45.0, 10.0};
  SlamNode node;
  sensor_msgs::msg::NavSatFix fix;
  fix.header.stamp.sec = 1700000000;
  fix.latitude = 45.0;
  fix.longitude = 10.0;
  fix.status.status = sensor_msgs::msg::NavSatStatus::STATUS_FIX;
  fix.position_covariance = {4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 9.0};
  const auto send = [&](std::int32_t later_s) {
    fix.header.stamp.sec = 1700000000 + later_s;
    subscribed<sensor_msgs::msg::NavSatFix>(node, "fix").callback(fix);
    node.timers.at(0)->callback();
    return published<nav_msgs::msg::Odometry>(node, "odometry").size();
  };
  EXPECT_EQ(send(0) + send(1) + send(2), 0U);  // of no known covariance: nothing was fed
  fix.position_covariance_type = sensor_msgs::msg::NavSatFix::COVARIANCE_TYPE_KNOWN;
  EXPECT_EQ(send(3), 0U);  // waits in the window
  EXPECT_EQ(send(4), 1U);
  rclcpp::Node::overrides.clear();
}

TEST(RosNodeTest, AnUnknownSettingStopsTheNodeAtItsStart) {
  rclcpp::Node::overrides["settings"] = std::vector<std::string>{"arrival.windows=1"};
  EXPECT_THROW(SlamNode node, std::invalid_argument);
  rclcpp::Node::overrides.clear();
}

}  // namespace
}  // namespace ssjs_ros
