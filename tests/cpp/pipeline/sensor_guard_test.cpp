#include "ssjs/pipeline/sensor_guard.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

NavigationTick depth_at(double time_s, double depth_m) {
  NavigationTick tick = tick_at(time_s);
  tick.depth_m = depth_m;
  return tick;
}

/// A gyro that moves beside whatever is asked.
NavigationTick with_gyro(NavigationTick tick) {
  tick.gyro_rad_s = Eigen::Vector3d(0.01 * std::sin(37.0 * tick.time_s), 0.0, 0.0);
  return tick;
}

TEST(SensorGuard, WhatNoVehicleDoesIsRefusedUntilEnoughGoodSamplesCome) {
  GuardConfig config;
  config.recover_samples = 3;
  SensorGuard guard(config);
  EXPECT_TRUE(guard.pass(depth_at(0.0, 12.0)).depth_m);
  EXPECT_FALSE(guard.pass(depth_at(0.1, -5e4)).depth_m);
  EXPECT_EQ(guard.fault(NavigationSensor::kDepth), SampleFault::kRange);
  EXPECT_FALSE(guard.pass(depth_at(0.2, 12.0)).depth_m);
  EXPECT_FALSE(guard.pass(depth_at(0.3, 12.1)).depth_m);
  EXPECT_TRUE(guard.pass(depth_at(0.4, 12.0)).depth_m);  // the third in a row
  EXPECT_EQ(guard.fault(NavigationSensor::kDepth), SampleFault::kNone);
  EXPECT_EQ(guard.refused(NavigationSensor::kDepth), 3);
  EXPECT_FALSE(guard.pass(depth_at(0.5, -5e4)).depth_m);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(guard.pass(depth_at(0.6 + 0.1 * i, 12.0 + 0.01 * i)).depth_m);
  EXPECT_TRUE(guard.pass(depth_at(1.2, 12.0)).depth_m);  // twice as many the second time
}

TEST(SensorGuard, AnotherUnitIsNamed) {
  SensorGuard guard{GuardConfig{}};
  EXPECT_TRUE(guard.pass(depth_at(0.0, 5.0)).depth_m);
  EXPECT_FALSE(guard.pass(depth_at(0.1, 5003.0)).depth_m);  // within the range, but 5.003 m in mm
  EXPECT_EQ(guard.fault(NavigationSensor::kDepth), SampleFault::kUnit);
  NavigationTick fast = tick_at(0.1);
  fast.velocity = VelocitySample{{1500.0, 12.0, -8.0}, true, std::nullopt};
  EXPECT_FALSE(guard.pass(fast).velocity);
  EXPECT_EQ(guard.fault(NavigationSensor::kVelocityLog), SampleFault::kUnit);
  NavigationTick degrees = tick_at(0.1);
  degrees.compass_rad = 271.5;
  EXPECT_FALSE(guard.pass(degrees).compass_rad);
  EXPECT_EQ(guard.fault(NavigationSensor::kCompass), SampleFault::kUnit);
}

TEST(SensorGuard, AHeadingThatCrossesNorthIsNoOtherUnit) {
  SensorGuard guard{GuardConfig{}};
  for (int i = 0; i < 200; ++i) {
    NavigationTick tick = tick_at(0.1 * i);
    const double heading = 6.2 + 0.002 * i;
    tick.compass_rad = heading < 2.0 * kPi ? heading : heading - 2.0 * kPi;
    EXPECT_TRUE(guard.pass(tick).compass_rad) << i;
  }
}

TEST(SensorGuard, AVelocityWithoutBottomLockIsNotLookedAt) {
  SensorGuard guard{GuardConfig{}};
  NavigationTick tick = tick_at(0.0);
  tick.velocity = VelocitySample{{-32768.0, 0.0, 0.0}, false, std::nullopt};
  EXPECT_TRUE(guard.pass(tick).velocity);
  EXPECT_EQ(guard.fault(NavigationSensor::kVelocityLog), SampleFault::kNone);
}

TEST(SensorGuard, ASensorThatHangsIsFoundWhileOthersMove) {
  SensorGuard guard{GuardConfig{}};  // 10 s; 30 s for what may be rounded
  double refused_from_s = 0.0;
  for (int i = 0; i < 600 && refused_from_s == 0.0; ++i) {
    if (!guard.pass(with_gyro(depth_at(0.1 * i, 11.83))).depth_m) refused_from_s = 0.1 * i;
  }
  EXPECT_NEAR(refused_from_s, 30.0, 0.2);
  EXPECT_EQ(guard.fault(NavigationSensor::kDepth), SampleFault::kStuck);
  EXPECT_TRUE(guard.pass(with_gyro(depth_at(60.0, 11.84))).depth_m);  // it moves again
  EXPECT_EQ(guard.fault(NavigationSensor::kDepth), SampleFault::kNone);
}

TEST(SensorGuard, NothingHangsWhereNothingMovesOrAllIsZero) {
  SensorGuard still{GuardConfig{}};
  SensorGuard at_the_surface{GuardConfig{}};
  for (int i = 0; i < 1000; ++i) {
    NavigationTick tick = depth_at(0.1 * i, 11.83);
    tick.gyro_rad_s = Eigen::Vector3d(0.01, 0.0, 0.0);  // a vehicle on deck, or a log that stands
    EXPECT_TRUE(still.pass(tick).depth_m);
    EXPECT_TRUE(at_the_surface.pass(with_gyro(depth_at(0.1 * i, 0.0))).depth_m);
  }
}

TEST(SensorGuard, AFloodOfSightingsIsBounded) {
  GuardConfig config;
  config.max_sightings_per_min = 60;
  SensorGuard guard(config);
  std::size_t passed = 0;
  for (int i = 0; i < 600; ++i) {  // 10,200 in a minute
    NavigationTick tick = tick_at(0.1 * i);
    tick.sightings.resize(17);
    passed += guard.pass(tick).sightings.size();
  }
  EXPECT_LE(passed, 120U);  // what was saved up and what came back in the minute
  EXPECT_GE(passed, 118U);
  EXPECT_EQ(guard.fault(NavigationSensor::kSideScan), SampleFault::kFlood);
  NavigationTick later = tick_at(120.0);
  later.sightings.resize(17);
  EXPECT_EQ(guard.pass(later).sightings.size(), 17U);
  EXPECT_EQ(guard.fault(NavigationSensor::kSideScan), SampleFault::kNone);
}

}  // namespace
}  // namespace ssjs
