#include "ssjs/sensors/navigation_sensors.hpp"

#include <gtest/gtest.h>

#include "geometry/numeric_jacobian.hpp"
#include "sensors/random_vehicle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_vehicle;

/// -d(residual)/d(state) by central differences against H, at a measurement that the state does not predict. The first `angles` rows wrap.
template <int Rows, class Sensor>
void expect_jacobian(const Sensor& rows_at, bool angles, std::uint64_t seed) {
  Rng rng(seed);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const VehicleVector x = random_vehicle(rng, point);
    const auto predicted = [&](const VehicleVector& v) -> Eigen::Matrix<double, Rows, 1> { return -rows_at(v).residual; };
    const VehicleRows rows = rows_at(x);
    EXPECT_GT(rows.residual.norm(), 1e-3);
    const Eigen::MatrixXd numeric = angles && Rows == 1   ? Eigen::MatrixXd(numeric_jacobian(predicted, x, {0}))
                                    : angles && Rows == 2 ? Eigen::MatrixXd(numeric_jacobian(predicted, x, {0, 1}))
                                                          : Eigen::MatrixXd(numeric_jacobian(predicted, x));
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(rows.H), numeric));
  }
}

TEST(NavigationSensors, A6_A7_A8_Jacobians) {
  expect_jacobian<2>([](const VehicleVector& x) { return attitude_rows(x, {0.4, -1.4}, {}); }, true, 51);
  expect_jacobian<1>([](const VehicleVector& x) { return compass_rows(x, 1.234, {}); }, true, 52);
  expect_jacobian<1>([](const VehicleVector& x) { return depth_rows(x, 30.0, {}); }, false, 53);
}

TEST(NavigationSensors, A9_AltitudeJacobiansVerticalAndAlongTheBody) {
  AltitudeConfig slanted;
  slanted.along_body_axis = true;
  expect_jacobian<1>([](const VehicleVector& x) { return altitude_rows(x, 1.0, {}); }, false, 54);
  expect_jacobian<1>([&](const VehicleVector& x) { return altitude_rows(x, 1.0, slanted); }, false, 55);
}

TEST(NavigationSensors, A10_VelocityLogJacobianWithMountingAndLeverArm) {
  VelocityLogConfig config;
  config.mount_roll_rad = kPi;
  config.mount_pitch_rad = 0.1;
  config.mount_yaw_rad = 0.7853981633974483;
  config.mount_forward_m = 0.8;
  config.mount_starboard_m = -0.2;
  config.mount_down_m = 0.3;
  const VelocitySample sample{{3.0, -1.0, 2.0}, true, {}};
  expect_jacobian<3>([&](const VehicleVector& x) { return velocity_log_rows(x, sample, Eigen::Vector3d(0.1, -0.2, 0.3), config); }, false,
                     56);
  expect_jacobian<3>([&](const VehicleVector& x) { return velocity_log_rows(x, sample, std::nullopt, config); }, false, 57);
}

TEST(NavigationSensors, A10_VelocityLogByHand) {
  // an instrument turned by 90 degrees sees the starboard velocity ahead and the forward velocity to port; 2 m ahead of the tracked point a
  // yaw rate of 0.5 rad/s adds 1 m/s to starboard
  VehicleVector x = VehicleVector::Zero();
  x(6) = 1.5;
  VelocityLogConfig config;
  config.mount_yaw_rad = kPi / 2.0;
  config.mount_forward_m = 2.0;
  const VehicleRows rows = velocity_log_rows(x, {{1.0, -1.5, 0.0}, true, 0.2}, Eigen::Vector3d(0.0, 0.0, 0.5), config);
  EXPECT_NEAR(rows.residual.norm(), 0.0, 1e-12);
  EXPECT_NEAR(rows.R(0, 0), 0.04, 1e-15);
}

TEST(NavigationSensors, A10_NoBottomLockHasNoRows) {
  VelocitySample sample;
  sample.bottom_lock = false;
  EXPECT_THROW((void)velocity_log_rows(VehicleVector::Zero(), sample, std::nullopt, {}), InvalidArgument);
}

TEST(NavigationSensors, RefuseNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)depth_rows(VehicleVector::Zero(), nan, {}), InvalidArgument);
  EXPECT_THROW((void)compass_rows(VehicleVector::Zero(), nan, {}), InvalidArgument);
  EXPECT_THROW((void)attitude_rows(VehicleVector::Zero(), {nan, 0.0}, {}), InvalidArgument);
  EXPECT_THROW((void)altitude_rows(VehicleVector::Zero(), nan, {}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
