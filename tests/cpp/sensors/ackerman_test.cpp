#include "ssjs/sensors/ackerman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

AckermanConfig car() {
  AckermanConfig config;  // the dimensions of the Victoria Park vehicle are the defaults
  config.steering_scale = 1.037;
  config.steering_offset_rad = 0.0043;
  return config;
}

AckermanControl random_control(Rng& rng) { return {rng.uniform(-6.0, 6.0), rng.uniform(-0.6, 0.6)}; }

TEST(Ackerman, M1_StraightAheadMovesTheReferencePointAlongTheHeading) {
  const MotionPrediction prediction = predict_ackerman({1.0, 2.0, kPi / 2.0}, {4.0, 0.0}, 0.5, AckermanConfig());
  EXPECT_NEAR(prediction.submap_T_vehicle.x, 1.0, 1e-12);
  EXPECT_NEAR(prediction.submap_T_vehicle.y, 2.0 + 4.0 * 0.5, 1e-12);
  EXPECT_NEAR(prediction.submap_T_vehicle.heading, kPi / 2.0, 1e-12);
}

TEST(Ackerman, M1_ALeftTurnByHand) {
  // tan(steering) = 0.5, L = 2, H = 1: q = 1 - 0.5 * 1 / 2 = 0.75, axle speed 3 / 0.75 = 4, curvature 0.25, turn rate 1 rad/s.
  // The reference point (a, b) = (3, 1) moves with 4 - 1 * 1 = 3 forward and 1 * 3 = 3 to the left.
  AckermanConfig config;
  config.wheelbase_m = 2.0;
  config.encoder_offset_m = 1.0;
  config.reference_forward_m = 3.0;
  config.reference_left_m = 1.0;
  const MotionPrediction prediction = predict_ackerman({0.0, 0.0, 0.0}, {3.0, std::atan(0.5)}, 0.01, config);
  EXPECT_NEAR(prediction.submap_T_vehicle.x, 0.03, 1e-12);
  EXPECT_NEAR(prediction.submap_T_vehicle.y, 0.03, 1e-12);
  EXPECT_NEAR(prediction.submap_T_vehicle.heading, 0.01, 1e-12);
}

TEST(Ackerman, M1_CalibrationTurnsTheMeasuredIntoTheTrueSteering) {
  AckermanConfig exact;
  const MotionPrediction expected = predict_ackerman({}, {3.0, 1.037 * 0.2 + 0.0043}, 0.1, exact);
  const MotionPrediction calibrated = predict_ackerman({}, {3.0, 0.2}, 0.1, car());
  EXPECT_NEAR(additive_difference(expected.submap_T_vehicle, calibrated.submap_T_vehicle).norm(), 0.0, 1e-14);
}

TEST(Ackerman, M1_HeadingsStayInsideTheCircle) {
  const MotionPrediction prediction = predict_ackerman({0.0, 0.0, 3.14}, {5.0, 0.5}, 0.1, AckermanConfig());
  EXPECT_LT(prediction.submap_T_vehicle.heading, -3.0);
  EXPECT_GE(prediction.submap_T_vehicle.heading, -kPi);
}

TEST(Ackerman, M2_PoseJacobian) {
  Rng rng(51);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const AckermanControl control = random_control(rng);
    const auto predict = [&](const Eigen::Vector3d& v) {
      return predict_ackerman(Se2::from_vector(v), control, 0.1, car()).submap_T_vehicle.vector();
    };
    EXPECT_TRUE(jacobians_agree(predict_ackerman(pose, control, 0.1, car()).F, numeric_jacobian(predict, pose.vector(), {2})));
  }
}

TEST(Ackerman, M3_M4_NoiseIsTheNumericJacobianOfTheMeasuredControlTimesItsVariance) {
  Rng rng(52);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const AckermanControl control = random_control(rng);
    AckermanConfig config = car();
    config.lateral_sigma_m_s = point % 3 == 0 ? 0.0 : 0.7;
    config.noise_step_s = 0.025;
    const double dt_s = 0.1;
    const auto predict = [&](const Eigen::Vector2d& v) {
      return predict_ackerman(pose, {v(0), v(1)}, dt_s, config).submap_T_vehicle.vector();
    };
    const Eigen::Matrix<double, 3, 2> G = numeric_jacobian(predict, Eigen::Vector2d(control.speed_m_s, control.steering_rad), {2});
    const Eigen::Vector3d G_lateral = dt_s * Eigen::Vector3d(-std::sin(pose.heading), std::cos(pose.heading), 0.0);
    const double samples_per_step = config.noise_step_s / dt_s;
    const Eigen::Vector2d variance(config.speed_sigma_m_s * config.speed_sigma_m_s, config.steering_sigma_rad * config.steering_sigma_rad);
    const Eigen::Matrix3d expected =
        samples_per_step * (G * variance.asDiagonal() * G.transpose() +
                            config.lateral_sigma_m_s * config.lateral_sigma_m_s * G_lateral * G_lateral.transpose());
    EXPECT_TRUE(jacobians_agree(predict_ackerman(pose, control, dt_s, config).Q, expected));
  }
}

TEST(Ackerman, M4_CuttingAStepInTwoChangesNothing) {
  AckermanConfig config = car();
  config.lateral_sigma_m_s = 0.5;
  const Se2 pose{1.0, 2.0, 3.1};
  const AckermanControl control{3.0, 0.1};
  const double dt_s = 1e-3;  // short, so that the two Euler steps equal the one to second order
  const MotionPrediction whole = predict_ackerman(pose, control, dt_s, config);
  const MotionPrediction first = predict_ackerman(pose, control, 0.5 * dt_s, config);
  const MotionPrediction second = predict_ackerman(first.submap_T_vehicle, control, 0.5 * dt_s, config);
  const Eigen::Matrix3d Q = second.F * first.Q * second.F.transpose() + second.Q;
  EXPECT_LT((Q - whole.Q).norm(), 1e-3 * whole.Q.norm());
  EXPECT_LT(additive_difference(whole.submap_T_vehicle, second.submap_T_vehicle).norm(), 1e-6);
}

TEST(Ackerman, M4_SideSlipMakesTheNoiseFullRank) {
  AckermanConfig config;
  const Se2 pose{0.0, 0.0, 0.7};
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> without(predict_ackerman(pose, {3.0, 0.1}, 0.1, config).Q);
  EXPECT_NEAR(without.eigenvalues()(0), 0.0, 1e-15);  // two noises in three dimensions
  config.lateral_sigma_m_s = 0.5;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> with(predict_ackerman(pose, {3.0, 0.1}, 0.1, config).Q);
  EXPECT_GT(with.eigenvalues()(0), 1e-8);
}

TEST(Ackerman, AStandingVehicleGetsNoNoiseAndAZeroStepChangesNothing) {
  AckermanConfig config;
  config.lateral_sigma_m_s = 0.5;
  const Se2 pose{1.0, 2.0, -3.0};
  const MotionPrediction standing = predict_ackerman(pose, {0.0, 0.3}, 0.5, config);
  EXPECT_EQ(standing.Q, Eigen::Matrix3d::Zero());
  EXPECT_EQ(standing.F, Eigen::Matrix3d::Identity());
  EXPECT_EQ(additive_difference(standing.submap_T_vehicle, pose), Eigen::Vector3d::Zero());
  const MotionPrediction instant = predict_ackerman(pose, {3.0, 0.3}, 0.0, config);
  EXPECT_EQ(instant.Q, Eigen::Matrix3d::Zero());
  EXPECT_EQ(additive_difference(instant.submap_T_vehicle, pose), Eigen::Vector3d::Zero());
}

TEST(Ackerman, BrokenContractsAreNamed) {
  const AckermanConfig config;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)predict_ackerman({}, {1.0, 0.0}, -0.1, config), InvalidArgument);
  EXPECT_THROW((void)predict_ackerman({}, {1.0, 0.0}, nan, config), InvalidArgument);
  EXPECT_THROW((void)predict_ackerman({}, {nan, 0.0}, 0.1, config), InvalidArgument);
  EXPECT_THROW((void)predict_ackerman({}, {1.0, nan}, 0.1, config), InvalidArgument);
  EXPECT_THROW((void)predict_ackerman({}, {1.0, 1.4}, 0.1, config), InvalidArgument);   // the turning centre lies inside the encoder wheel
  EXPECT_THROW((void)predict_ackerman({}, {1.0, -1.6}, 0.1, config), InvalidArgument);  // beyond a right angle
}

}  // namespace
}  // namespace ssjs
