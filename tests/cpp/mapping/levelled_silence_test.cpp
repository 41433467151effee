#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "ssjs/base/angle.hpp"
#include "ssjs/mapping/levelled_builder.hpp"

namespace ssjs {
namespace {

constexpr double kSpeed = 1.5;

/// A vehicle that goes straight ahead: every sensor, or a velocity log that is silent.
NavigationTick straight(double time_s, bool with_velocity = true) {
  NavigationTick tick = tick_at(time_s);
  tick.gyro_rad_s = Eigen::Vector3d::Zero();
  tick.roll_pitch_rad = Eigen::Vector2d::Zero();
  tick.compass_rad = 0.3;
  tick.depth_m = 12.0;
  tick.altitude_m = 4.0;
  if (with_velocity) tick.velocity = VelocitySample{{kSpeed, 0.0, 0.0}, true, std::nullopt};
  return tick;
}

double drive(LevelledBuilder& builder, double from_s, double seconds) {
  double time_s = from_s;
  for (; time_s < from_s + seconds; time_s += 0.2) static_cast<void>(builder.feed(straight(time_s)));
  return time_s;
}

/// v_max = 1.5 + 2 * 1 m/s: somewhere in a disc of 3.5 m/s times the silence, half of it a standard deviation; any heading.
TEST(LevelledSilence, A26_AfterHoursNothingIsKnownButTheReachAndTheMapEnds) {
  for (const double silence_s : {2000.0, 7200.0, 10.0 * 86400.0, 1e9}) {  // of more than 1e6 s no vehicle is told apart
    LevelledBuilder builder{LevelledBuilderConfig{}};
    const double time_s = drive(builder, 0.0, 20.0);
    const TickResult after = builder.feed(straight(time_s + silence_s));
    ASSERT_TRUE(after.closed) << silence_s;
    EXPECT_EQ(after.closed->closed_because, "silence");
    EXPECT_NEAR(std::sqrt(after.closed->covariance(0, 0)) / (0.5 * 3.5 * std::min(silence_s, 1e6)), 1.0, 0.01);
    EXPECT_NEAR(after.closed->covariance(2, 2), kPi * kPi / 3.0, 0.01);
    EXPECT_TRUE(after.closed->covariance.allFinite());
    drive(builder, time_s + silence_s + 0.2, 20.0);
    EXPECT_LT(std::sqrt(builder.filter().vehicle_covariance()(0, 0)), 1.0);  // of a map that knows nothing of it
  }
}

/// 20 s at 1.5 m/s: a vehicle that stood still is 30 m behind, two standard deviations.
TEST(LevelledSilence, A26_SecondsOfSilenceAreDoubtedAndTheMapEnds) {
  LevelledBuilder builder{LevelledBuilderConfig{}};
  const double time_s = drive(builder, 0.0, 20.0);
  static_cast<void>(builder.feed(tick_at(time_s - 0.2 + 20.0)));
  EXPECT_GT(std::sqrt(builder.filter().vehicle_covariance()(0, 0)), 15.0);
  EXPECT_GT(std::sqrt(builder.filter().vehicle_covariance()(1, 1)), 15.0);
  EXPECT_FALSE(builder.feed(straight(time_s + 20.0)).closed);     // it has to be level first
  const TickResult next = builder.feed(straight(time_s + 20.2));  // what comes is seen from another map
  ASSERT_TRUE(next.closed);
  EXPECT_EQ(next.closed->closed_because, "silence");
  EXPECT_GT(std::sqrt(next.closed->covariance(0, 0)), 15.0);
}

TEST(LevelledSilence, A26_ASampleThatIsMissingEndsNoMap) {
  LevelledBuilder builder{LevelledBuilderConfig{}};
  const double time_s = drive(builder, 0.0, 20.0);
  EXPECT_FALSE(builder.feed(straight(time_s + 4.0)).closed);
}

TEST(LevelledSilence, P30_AFixClosesTheMapAtTheNextVelocityAndIsSeenFromThere) {
  LevelledBuilder builder{LevelledBuilderConfig{}};
  const double last_s = drive(builder, 0.0, 10.0) - 0.2;
  NavigationTick fix = tick_at(last_s + 0.05);
  fix.fix = PositionFix{{100.0, 200.0}, Eigen::Matrix2d::Identity(), false};
  EXPECT_FALSE(builder.feed(fix).closed);
  const TickResult result = builder.feed(straight(last_s + 0.2));
  ASSERT_TRUE(result.closed);
  EXPECT_EQ(result.closed->closed_because, "fix");
  ASSERT_TRUE(result.closed->exit_fix);
  EXPECT_NEAR(result.closed->exit_fix->base_p_vehicle.x(), -kSpeed * 0.15, 0.02);  // 0.15 s behind the base
  EXPECT_NEAR(result.closed->exit_fix->base_p_vehicle.y(), 0.0, 0.01);
  EXPECT_GT(result.closed->exit_fix->fix.covariance(0, 0), 1.0);
  NavigationTick soon = straight(last_s + 6.0);  // within the interval of 10 s
  soon.fix = fix.fix;
  EXPECT_FALSE(builder.feed(soon).closed);
}

TEST(LevelledSilence, P30_AFixDoesNotWaitForAVelocityForEver) {
  LevelledBuilder builder{LevelledBuilderConfig{}};
  const double last_s = drive(builder, 0.0, 10.0) - 0.2;
  std::optional<double> closed_s;
  for (double time_s = last_s + 0.2; time_s < last_s + 5.0 && !closed_s; time_s += 0.2) {
    NavigationTick tick = straight(time_s, false);
    if (time_s < last_s + 0.3) tick.fix = PositionFix{{100.0, 200.0}, Eigen::Matrix2d::Identity(), false};
    if (builder.feed(tick).closed) closed_s = time_s;
  }
  ASSERT_TRUE(closed_s);
  EXPECT_NEAR(*closed_s - last_s, 2.4, 0.11);  // more than two seconds after the fix
}

}  // namespace
}  // namespace ssjs
