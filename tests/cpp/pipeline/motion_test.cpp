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

}  // namespace
}  // namespace ssjs
