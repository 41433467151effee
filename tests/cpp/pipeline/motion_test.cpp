#include "ssjs/pipeline/motion.hpp"

#include <gtest/gtest.h>

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

TEST(Motion, ACommandHoldsUntilTheNextOne) {
  VehicleConfig config;
  config.kind = VehicleKind::kUnicycle;
  OdometryMotion motion(config);
  motion.take({1.0, VelocityControl{2.0, 0.0}});
  EXPECT_FALSE(motion.from({}).has_value());  // nothing held before
  motion.take({1.5, VelocityControl{8.0, 0.0}});
  EXPECT_NEAR(motion.from({})->submap_T_vehicle.x, 1.0, 1e-12);  // 0.5 s at the old 2 m/s
  motion.take({1.5, Features{}});
  EXPECT_FALSE(motion.from({}).has_value());  // no time has passed
  motion.take({1.75, Features{}});
  EXPECT_NEAR(motion.from({1.0, 0.0, 0.0})->submap_T_vehicle.x, 3.0, 1e-12);
}

TEST(Motion, AnIncrementLeadsToItsTime) {
  VehicleConfig config;
  config.kind = VehicleKind::kIncrements;
  OdometryMotion motion(config);
  const OdometryIncrement increment{{{1.0, 0.5, 0.1}, Eigen::Matrix3d::Identity()}};
  motion.take({1.0, increment});
  const Se2 pose{3.0, 4.0, 0.7};
  EXPECT_EQ(motion.from(pose)->submap_T_vehicle.vector(), (pose * increment.old_T_new.mean).vector());
  motion.take({2.0, Features{}});
  EXPECT_FALSE(motion.from(pose).has_value());
}

}  // namespace
}  // namespace ssjs
