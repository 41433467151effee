#include "ssjs/sensors/constant_velocity.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "sensors/random_vehicle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_vehicle;

ConstantVelocityConfig driven_by(RotationDrive drive) {
  ConstantVelocityConfig config;
  config.drive = drive;
  return config;
}

TEST(ConstantVelocity, A2_ByHand) {
  // heading east, nose 30 degrees up, 2 m/s ahead for half a second: 1 m along the body, cos 30 of it east, sin 30 of it up
  VehicleVector x = VehicleVector::Zero();
  x(4) = kPi / 6.0;
  x(5) = kPi / 2.0;
  x(6) = 2.0;
  const VehiclePrediction p = predict_constant_velocity(x, {0.0, 0.0, 0.1}, 0.5, driven_by(RotationDrive::kGyro));
  EXPECT_NEAR(p.state(0), 0.0, 1e-12);
  EXPECT_NEAR(p.state(1), std::sqrt(0.75), 1e-12);
  EXPECT_NEAR(p.state(2), -0.5, 1e-12);
  EXPECT_NEAR(p.state(5), kPi / 2.0 + 0.05 / std::cos(kPi / 6.0), 1e-12);  // the yaw rate of a pitched vehicle
}

TEST(ConstantVelocity, A3_Jacobian) {
  Rng rng(41);
  for (const RotationDrive drive : {RotationDrive::kGyro, RotationDrive::kRates, RotationDrive::kConstantAttitude}) {
    const ConstantVelocityConfig config = driven_by(drive);
    for (int point = 0; point < kJacobianPoints; ++point) {
      const VehicleVector x = random_vehicle(rng, point);
      const Eigen::Vector3d gyro(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5));
      const auto step = [&](const VehicleVector& v) { return predict_constant_velocity(v, gyro, 0.3, config).state; };
      EXPECT_TRUE(jacobians_agree(predict_constant_velocity(x, gyro, 0.3, config).F, numeric_jacobian(step, x, {3, 4, 5, 10, 11})));
    }
  }
}

TEST(ConstantVelocity, A4_NoiseOfTwoHalfStepsIsThatOfOne) {
  // white noise and random walks do not know how time is cut; position through velocity to second order in the step
  Rng rng(42);
  for (const RotationDrive drive : {RotationDrive::kGyro, RotationDrive::kRates, RotationDrive::kConstantAttitude}) {
    const ConstantVelocityConfig config = driven_by(drive);
    VehicleVector x = random_vehicle(rng, 0);
    x.segment<3>(VehicleLayout::kRates).setZero();
    x.segment<3>(VehicleLayout::kGyroBias).setZero();
    const double dt = 1e-2;
    const VehiclePrediction whole = predict_constant_velocity(x, Eigen::Vector3d::Zero(), dt, config);
    const VehiclePrediction half = predict_constant_velocity(x, Eigen::Vector3d::Zero(), dt / 2, config);
    const VehicleMatrix twice = half.F * half.Q * half.F.transpose() + half.Q;
    EXPECT_NEAR((twice - whole.Q).norm() / whole.Q.norm(), 0.0, 2e-2);
    EXPECT_NEAR((twice.diagonal().tail<17>() - whole.Q.diagonal().tail<17>()).cwiseAbs().maxCoeff() / whole.Q.norm(), 0.0, 1e-3);
  }
}

TEST(ConstantVelocity, A5_LevelModelIsTheFullOneOfALevelVehicle) {
  Rng rng(43);
  const ConstantVelocityConfig config = driven_by(RotationDrive::kGyro);
  for (int point = 0; point < kJacobianPoints; ++point) {
    VehicleVector x = random_vehicle(rng, point);
    x(3) = x(4) = 0.0;
    x.segment<3>(VehicleLayout::kGyroBias).setZero();
    LevelVehicleVector level;
    level << position_of(x), x(5), velocity_of(x);
    const double rate = rng.uniform(-0.3, 0.3);
    const VehiclePrediction full = predict_constant_velocity(x, {0.0, 0.0, rate}, 0.4, config);
    const LevelVehiclePrediction reduced = predict_constant_velocity_level(level, rate, 0.4, config);
    const std::vector<Eigen::Index> kept{0, 1, 2, 5, 6, 7, 8};
    EXPECT_NEAR((full.state(kept) - reduced.state).norm(), 0.0, 1e-12);
    EXPECT_NEAR((full.Q(kept, kept) - reduced.Q).norm(), 0.0, 1e-12);
    EXPECT_NEAR((full.F(kept, kept) - reduced.F).norm(), 0.0, 1e-12);
    const auto step = [&](const LevelVehicleVector& v) { return predict_constant_velocity_level(v, rate, 0.4, config).state; };
    EXPECT_TRUE(jacobians_agree(reduced.F, numeric_jacobian(step, level, {3})));
  }
}

TEST(ConstantVelocity, RefusesWhatItCannotPredict) {
  VehicleVector x = VehicleVector::Zero();
  EXPECT_THROW((void)predict_constant_velocity(x, Eigen::Vector3d::Zero(), -0.1, {}), InvalidArgument);
  EXPECT_THROW((void)predict_constant_velocity_level(LevelVehicleVector::Zero(), 0.0, 0.1, driven_by(RotationDrive::kRates)),
               InvalidArgument);
  x(4) = kPi / 2.0;
  EXPECT_THROW((void)predict_constant_velocity(x, Eigen::Vector3d::Zero(), 0.1, {}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
