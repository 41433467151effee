#include "ssjs/joining/timed_closure.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const Eigen::Matrix3d kNoise = Eigen::Vector3d(0.04, 0.09, 1e-4).asDiagonal();

/// Map 0 goes 20 m ahead in 10 s and turns right, map 1 goes 10 m ahead in 10 s; a step each second, known to 0.1 m and 0.01 rad.
std::deque<PortMap> two_maps() {
  std::deque<PortMap> maps;
  const Se2 exits[] = {{20.0, 0.0, 0.5 * kPi}, {10.0, 0.0, 0.0}};
  for (int k = 0; k < 2; ++k) {
    LevelledSubmap map;
    map.index = k;
    map.start_time_s = 10.0 * k;
    map.end_time_s = 10.0 * (k + 1);
    map.mean = exits[k].vector();
    map.covariance = 0.01 * Eigen::Matrix3d::Identity();
    for (int i = 1; i < 10; ++i) {
      LevelledStep step;
      step.time_s = map.start_time_s + i;
      step.base_T_vehicle(0) = 0.1 * exits[k].x * i;
      step.covariance = 0.01 * Matrix6d::Identity();
      step.covariance(5, 5) = 1e-4;
      map.steps.push_back(step);
    }
    maps.push_back({map, {}});
  }
  return maps;
}

TEST(TimedClosure, C13_IsTakenFromTheVehicleToTheBases) {
  // At 4.5 s the vehicle is 9 m along map 0, at 12 s 2 m along map 1: base 1 is at (20, 0) and looks to starboard, the vehicle at (20, 2).
  const TimedClosure closure{4.5, 12.0, {{11.0, 2.0, 0.5 * kPi}, kNoise}, "pier"};
  const std::optional<Closure> found = between_bases(closure, two_maps());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->from, 0);
  EXPECT_EQ(found->to, 1);
  EXPECT_EQ(found->source, "pier");
  EXPECT_LT(additive_difference(found->from_T_to->mean, {20.0, 0.0, 0.5 * kPi}).norm(), 1e-12);
  // Along x: 0.1 m of both steps, 0.2 m of the closure, and the heading errors over levers of 0 (the earlier step turns (11, 0) sideways).
  // The lever of base 1 from the later vehicle is 2 m along y: heading errors of all three, 1e-4 rad^2 each, seen over it.
  // earlier heading: acts on (20 - 9, 0): x unmoved. closure heading and later heading: base 1 lies 2 m behind: (0, -2) turned by pi/2.
  const Eigen::Matrix3d& P = found->from_T_to->covariance;
  EXPECT_NEAR(P(0, 0), 0.01 + 0.04 + 0.01 + 2.0 * 4.0 * 1e-4, 1e-12);
  EXPECT_NEAR(P(1, 1), 0.01 + 0.09 + 0.01 + 11.0 * 11.0 * 1e-4, 1e-12);
  EXPECT_NEAR(P(2, 2), 3e-4, 1e-15);
}

TEST(TimedClosure, WhereThereIsNoWayThereIsNoClosure) {
  std::deque<PortMap> maps = two_maps();
  const GaussianSe2 pose{{1.0, 0.0, 0.0}, kNoise};
  EXPECT_FALSE(between_bases({2.0, 8.0, pose, ""}, maps));    // one map
  EXPECT_FALSE(between_bases({-1.0, 12.0, pose, ""}, maps));  // before the first
  EXPECT_FALSE(between_bases({2.0, 20.5, pose, ""}, maps));   // after the last
  EXPECT_TRUE(between_bases({0.0, 20.0, pose, ""}, maps));
  maps[0].submap.steps.resize(2);
  EXPECT_FALSE(between_bases({6.0, 12.0, pose, ""}, maps));  // 8 s without a step
}

TEST(TimedClosure, WhatIsNoneIsRefused) {
  const GaussianSe2 pose{{1.0, 0.0, 0.0}, kNoise};
  EXPECT_NO_THROW(check({1.0, 2.0, pose, ""}));
  EXPECT_THROW(check({2.0, 2.0, pose, ""}), InvalidArgument);
  EXPECT_THROW(check({1.0, HUGE_VAL, pose, ""}), InvalidArgument);
  EXPECT_THROW(check({1.0, 2.0, {{std::nan(""), 0.0, 0.0}, kNoise}, ""}), InvalidArgument);
  EXPECT_THROW(check({1.0, 2.0, {{1e200, 0.0, 0.0}, kNoise}, ""}), InvalidArgument);
  for (const double scale : {0.0, 1e-310, 1e300}) {
    EXPECT_THROW(check({1.0, 2.0, {{}, scale * Eigen::Matrix3d::Identity()}, ""}), InvalidArgument) << scale;
  }
}

}  // namespace
}  // namespace ssjs
