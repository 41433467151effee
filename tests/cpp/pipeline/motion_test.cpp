#include "ssjs/pipeline/motion.hpp"

#include <gtest/gtest.h>

#include "geometry/numeric_jacobian.hpp"

namespace ssjs {
namespace {

TEST(Motion, HoldsTheCommandWithTheConfiguredModel) {
  VehicleConfig config;
  config.ackerman.speed_sigma_m_s = 0.7;
  config.unicycle.speed_sigma_m_s = 0.9;
  const Se2 pose{1.0, 2.0, 0.3};
  const MotionPrediction ackerman = hold_command(pose, {5.0, AckermanControl{2.0, 0.1}}, 0.5, config);
  const MotionPrediction expected = predict_ackerman(pose, {2.0, 0.1}, 0.5, config.ackerman);
  EXPECT_EQ(ackerman.submap_T_vehicle.vector(), expected.submap_T_vehicle.vector());
  EXPECT_EQ(ackerman.Q, expected.Q);
  const MotionPrediction unicycle = hold_command(pose, {5.0, VelocityControl{2.0, 0.1}}, 0.5, config);
  EXPECT_EQ(unicycle.Q, predict_unicycle(pose, {2.0, 0.1}, 0.5, config.unicycle).Q);
}

TEST(Motion, G1_G4_AnIncrementPredictsWhatTheCommandDoes) {
  // The same pose, Jacobian and noise by way of the increment, for both kinds of command; and the Jacobians are derivatives.
  Rng rng(901);
  VehicleConfig config;
  config.ackerman.lateral_sigma_m_s = 0.2;
  config.unicycle.lateral_sigma_m_s = 0.2;
  for (int i = 0; i < testing::kJacobianPoints; ++i) {
    const Se2 pose = testing::random_pose(rng, i);
    const Event commands[] = {{0.0, AckermanControl{rng.uniform(-3.0, 3.0), rng.uniform(-0.5, 0.5)}},
                              {0.0, VelocityControl{rng.uniform(-3.0, 3.0), rng.uniform(-1.0, 1.0)}}};
    for (const Event& command : commands) {
      const MotionPrediction direct = hold_command(pose, command, 0.4, config);
      const OdometryIncrement increment = command_increment(command, 0.4, config);
      const MotionPrediction prediction = predict_increment(pose, increment);
      EXPECT_LE(additive_difference(prediction.submap_T_vehicle, direct.submap_T_vehicle).norm(), 1e-12);
      EXPECT_LE((prediction.F - direct.F).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_LE((prediction.Q - direct.Q).cwiseAbs().maxCoeff(), 1e-12);

      const auto by_pose = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
        return (Se2::from_vector(x) * increment.old_T_new.mean).vector();
      };
      const auto by_increment = [&](const Eigen::Vector3d& d) -> Eigen::Vector3d { return (pose * Se2::from_vector(d)).vector(); };
      const Eigen::Matrix3d J_v = testing::numeric_jacobian(by_pose, pose.vector(), {2});
      const Eigen::Matrix3d Q_v = testing::numeric_jacobian(by_increment, increment.old_T_new.mean.vector(), {2});
      EXPECT_LE((prediction.F - J_v).cwiseAbs().maxCoeff(), testing::kJacobianTolerance);
      const Eigen::Matrix3d Q = Q_v * increment.old_T_new.covariance * Q_v.transpose();
      EXPECT_LE((prediction.Q - Q).cwiseAbs().maxCoeff(), testing::kJacobianTolerance);
    }
  }
}

TEST(Motion, ACommandHoldsUntilTheNextOne) {
  VehicleConfig config;
  config.kind = VehicleKind::kUnicycle;
  OdometryMotion motion(config);
  motion.take({1.0, VelocityControl{2.0, 0.0}});
  EXPECT_FALSE(motion.increment().has_value());  // nothing held before
  motion.take({1.5, VelocityControl{8.0, 0.0}});
  EXPECT_NEAR(motion.increment()->old_T_new.mean.x, 1.0, 1e-12);  // 0.5 s at the old 2 m/s
  motion.take({1.5, Features{}});
  EXPECT_FALSE(motion.increment().has_value());  // no time has passed
  motion.take({1.75, Features{}});
  EXPECT_NEAR(motion.increment()->old_T_new.mean.x, 2.0, 1e-12);
}

/// 20 s at 2 m/s: 40 m, half of it beside what the noise of the speed gives; no more for a step of the usual length.
TEST(Motion, WhatACommandDoesOverASilenceIsAGuess) {
  VehicleConfig config;
  config.kind = VehicleKind::kUnicycle;
  const Event command{0.0, VelocityControl{2.0, 0.0}};
  OdometryMotion motion(config);
  for (int i = 0; i < 100; ++i) motion.take({0.1 * i, VelocityControl{2.0, 0.0}});
  motion.take({10.0, Features{}});
  EXPECT_EQ(motion.increment()->old_T_new.covariance, command_increment(command, 10.0 - 0.1 * 99, config).old_T_new.covariance);
  motion.take({30.0, Features{}});
  const Eigen::Matrix3d doubt = motion.increment()->old_T_new.covariance - command_increment(command, 20.0, config).old_T_new.covariance;
  EXPECT_NEAR(doubt(0, 0), 400.0, 1e-9);
  EXPECT_NEAR(doubt(1, 1), 400.0, 1e-9);
  EXPECT_NEAR(doubt(2, 2), 0.0, 1e-12);
  motion.take({30.0 + 3600.0, Features{}});
  EXPECT_GT(motion.increment()->old_T_new.covariance(2, 2), 3.2);  // pi^2 / 3
}

TEST(Motion, AnIncrementLeadsToItsTime) {
  VehicleConfig config;
  config.kind = VehicleKind::kIncrements;
  OdometryMotion motion(config);
  const OdometryIncrement increment{{{1.0, 0.5, 0.1}, Eigen::Matrix3d::Identity()}};
  motion.take({1.0, increment});
  EXPECT_EQ(motion.increment()->old_T_new.mean.vector(), increment.old_T_new.mean.vector());
  motion.take({2.0, Features{}});
  EXPECT_FALSE(motion.increment().has_value());
}

}  // namespace
}  // namespace ssjs
