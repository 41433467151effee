#include "ssjs/sensors/unicycle.hpp"

#include <gtest/gtest.h>

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

/// Turns of all sizes: none, tiny, on both sides of where the series end, and large.
VelocityControl random_control(Rng& rng, int point) {
  const double turn_rates[] = {0.0, 1e-7, 0.0099 / 0.1, 0.0101 / 0.1, rng.uniform(-10.0, 10.0)};
  return {rng.uniform(-3.0, 3.0), turn_rates[point % 5]};
}

TEST(Unicycle, M5_AQuarterOfACircleByHand) {
  // 2 m/s and pi/4 rad/s for 2 s: a quarter of the circle of radius 8 / pi
  const double radius = 8.0 / kPi;
  const Se2 pose = predict_unicycle({}, {2.0, kPi / 4.0}, 2.0, UnicycleConfig()).submap_T_vehicle;
  EXPECT_NEAR(pose.x, radius, 1e-12);
  EXPECT_NEAR(pose.y, radius, 1e-12);
  EXPECT_NEAR(pose.heading, kPi / 2.0, 1e-12);
}

TEST(Unicycle, M5_SeriesAndQuotientsMeet) {
  // the same arc in one step (quotients) and in many (series)
  const VelocityControl control{1.5, 0.3};
  Se2 pose;
  for (int step = 0; step < 100; ++step) pose = predict_unicycle(pose, control, 0.02, UnicycleConfig()).submap_T_vehicle;
  EXPECT_NEAR(additive_difference(pose, predict_unicycle({}, control, 2.0, UnicycleConfig()).submap_T_vehicle).norm(), 0.0, 1e-12);
}

TEST(Unicycle, M6_PoseJacobian) {
  Rng rng(61);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const VelocityControl control = random_control(rng, point);
    const auto predict = [&](const Eigen::Vector3d& v) {
      return predict_unicycle(Se2::from_vector(v), control, 0.1, UnicycleConfig()).submap_T_vehicle.vector();
    };
    EXPECT_TRUE(jacobians_agree(predict_unicycle(pose, control, 0.1, UnicycleConfig()).F, numeric_jacobian(predict, pose.vector(), {2})));
  }
}

TEST(Unicycle, M7_NoiseIsTheNumericJacobianOfTheCommandTimesItsVariance) {
  Rng rng(62);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const VelocityControl control = random_control(rng, point);
    UnicycleConfig config;
    config.speed_sigma_m_s = 0.2;
    config.speed_sigma_fraction = 0.1;
    config.turn_rate_sigma_rad_s = 0.3;
    config.turn_rate_sigma_fraction = 0.05;
    config.lateral_sigma_m_s = 0.4;
    config.noise_step_s = 0.02;
    const double dt_s = 0.1;
    // the side slip is the second component of the twist
    const auto predict = [&](const Eigen::Vector3d& v) { return (pose * se2_exp(dt_s * Eigen::Vector3d(v(0), v(2), v(1)))).vector(); };
    const Eigen::Matrix3d G = numeric_jacobian(predict, Eigen::Vector3d(control.speed_m_s, control.turn_rate_rad_s, 0.0), {2});
    const Eigen::Vector3d variance(0.04 + 0.01 * control.speed_m_s * control.speed_m_s,
                                   0.09 + 0.0025 * control.turn_rate_rad_s * control.turn_rate_rad_s, 0.16);
    const Eigen::Matrix3d expected = (config.noise_step_s / dt_s) * G * variance.asDiagonal() * G.transpose();
    EXPECT_TRUE(jacobians_agree(predict_unicycle(pose, control, dt_s, config).Q, expected));
  }
}

TEST(Unicycle, M7_CuttingAStepInTwoChangesNothing) {
  UnicycleConfig config;
  config.lateral_sigma_m_s = 0.1;
  const VelocityControl control{1.0, 0.5};
  const double dt_s = 1e-3;
  const MotionPrediction whole = predict_unicycle({1.0, 2.0, -3.1}, control, dt_s, config);
  const MotionPrediction first = predict_unicycle({1.0, 2.0, -3.1}, control, 0.5 * dt_s, config);
  const MotionPrediction second = predict_unicycle(first.submap_T_vehicle, control, 0.5 * dt_s, config);
  const Eigen::Matrix3d Q = second.F * first.Q * second.F.transpose() + second.Q;
  EXPECT_LT((Q - whole.Q).norm(), 1e-3 * whole.Q.norm());
}

TEST(Unicycle, ATurnOnTheSpotIsNoisyAndStandingIsNot) {
  const UnicycleConfig config;
  EXPECT_GT(predict_unicycle({}, {0.0, 0.5}, 0.1, config).Q(2, 2), 0.0);
  EXPECT_EQ(predict_unicycle({}, {0.0, 0.0}, 0.1, config).Q, Eigen::Matrix3d::Zero());
}

TEST(Unicycle, BrokenContractsAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)predict_unicycle({}, {1.0, 0.0}, -0.1, UnicycleConfig()), InvalidArgument);
  EXPECT_THROW((void)predict_unicycle({}, {nan, 0.0}, 0.1, UnicycleConfig()), InvalidArgument);
  EXPECT_THROW((void)predict_unicycle({}, {1.0, nan}, 0.1, UnicycleConfig()), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
