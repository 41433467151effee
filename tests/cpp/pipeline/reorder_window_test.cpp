#include "ssjs/pipeline/reorder_window.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace ssjs {
namespace {

NavigationTick sample(double time_s, int kind) {
  NavigationTick tick = tick_at(time_s);
  if (kind == 0) tick.depth_m = 12.0;
  if (kind == 1) tick.compass_rad = 0.3;
  if (kind == 2) tick.roll_pitch_rad = Eigen::Vector2d(0.01, 0.02);
  return tick;
}

struct Fed {
  std::vector<double> times_s;  ///< of the ticks taken
  int taken = 0, late = 0, jumps = 0;
};

/// Three sensors at 10 Hz whose clock is set by `by_s` after 20 s.
Fed feed(ReorderWindow& window, double by_s, int seconds = 60) {
  Fed fed;
  for (int i = 0; i < 10 * seconds; ++i) {
    const double stamp_s = 0.1 * i + (i >= 200 ? by_s : 0.0);
    for (int kind = 0; kind < 3; ++kind) {
      const Arrival arrival = window.put(sample(stamp_s, kind));
      fed.taken += arrival == Arrival::kTaken ? 1 : 0;
      fed.late += arrival == Arrival::kLate ? 1 : 0;
      fed.jumps += arrival == Arrival::kClockJump ? 1 : 0;
      while (const auto tick = window.take()) fed.times_s.push_back(tick->time_s);
    }
  }
  return fed;
}

TEST(ReorderWindow, AClockThatIsSetBackCostsTenSamplesAndTimeGoesOn) {
  for (const double by_s : {-5.0, -3600.0, -1e6}) {
    ReorderWindow window{ReorderConfig{}};
    const Fed fed = feed(window, by_s);
    EXPECT_EQ(fed.late, 9) << by_s;  // with the tenth the clock is known to have been set
    EXPECT_EQ(fed.taken, 1800 - 9);
    EXPECT_EQ(window.clock_changes(), 1);
    EXPECT_NEAR(window.clock_offset_s(), -by_s, 0.2);
    EXPECT_TRUE(std::is_sorted(fed.times_s.begin(), fed.times_s.end()));
    EXPECT_NEAR(fed.times_s.back(), 59.0, 0.5);
  }
}

TEST(ReorderWindow, OneSensorThatLagsDoesNotSetTheClock) {
  ReorderWindow window{ReorderConfig{}};
  int late = 0;
  for (int i = 0; i < 600; ++i) {
    EXPECT_EQ(window.put(sample(0.1 * i, 0)), Arrival::kTaken);
    EXPECT_EQ(window.put(sample(0.1 * i, 1)), Arrival::kTaken);
    late += window.put(sample(0.1 * i - 7.0, 2)) == Arrival::kLate ? 1 : 0;
    while (window.take()) {
    }
  }
  EXPECT_GE(late, 590);
  EXPECT_EQ(window.clock_changes(), 0);
}

TEST(ReorderWindow, AGapIsASilenceUnlessItIsKnownToBeTheClock) {
  ReorderWindow silent{ReorderConfig{}};
  const Fed gap = feed(silent, 7200.0);
  EXPECT_EQ(gap.jumps, 4);
  EXPECT_NEAR(gap.times_s.back(), 7259.0, 0.5);
  EXPECT_EQ(silent.clock_changes(), 0);
  ReorderConfig config;
  config.gaps_are_silence = false;
  ReorderWindow set(config);
  const Fed went_on = feed(set, 7200.0);
  EXPECT_NEAR(went_on.times_s.back(), 59.0, 0.5);
  EXPECT_EQ(set.clock_changes(), 1);
  EXPECT_TRUE(std::is_sorted(went_on.times_s.begin(), went_on.times_s.end()));
}

TEST(ReorderWindow, ASightingWhoseCovarianceIsNoneIsRefused) {
  ReorderWindow window{ReorderConfig{}};
  NavigationTick tick = tick_at(1.0);
  tick.sightings.resize(1);
  EXPECT_EQ(window.put(tick), Arrival::kTaken);  // the sonar's own
  Eigen::Matrix3d& R = tick.sightings.front().covariance.emplace(Eigen::Matrix3d::Identity());
  EXPECT_EQ(window.put(tick), Arrival::kTaken);
  R(1, 0) = 0.1;
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);  // not symmetric
  R(1, 0) = R(0, 1) = 1.1;
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);  // not definite
  R = Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal();
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);  // exact
  R.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);
}

TEST(ReorderWindow, AFixWithoutACovarianceIsNone) {
  ReorderWindow window{ReorderConfig{}};
  NavigationTick tick = tick_at(1.0);
  tick.fix.emplace();
  EXPECT_EQ(window.put(tick), Arrival::kTaken);
  EXPECT_EQ(window.put(tick), Arrival::kDuplicate);
  tick.time_s = 2.0;
  tick.fix->covariance << 1.0, 2.0, 2.0, 1.0;
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);
  tick.fix->covariance = 1e-310 * Eigen::Matrix2d::Identity();  // whose inverse is not finite
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);
  tick.fix->covariance.setIdentity();
  tick.fix->world_p_vehicle.x() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(window.put(tick), Arrival::kNotFinite);
}

TEST(ReorderWindow, SightingsThatWaitAreBounded) {
  ReorderConfig config;
  config.capacity = 100;
  ReorderWindow window(config);
  int taken = 0;
  for (int i = 0; i < 1000; ++i) {
    NavigationTick tick = tick_at(10.0);
    tick.sightings.emplace_back();
    taken += window.put(tick) == Arrival::kTaken ? 1 : 0;
  }
  EXPECT_EQ(taken, 100);
}

}  // namespace
}  // namespace ssjs
