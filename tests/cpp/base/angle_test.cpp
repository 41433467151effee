#include "ssjs/base/angle.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ssjs {
namespace {

const double kBelowPi = std::nextafter(kPi, 0.0);

TEST(WrapAngle, KeepsWhatIsAlreadyInside) {
  for (const double angle : {0.0, -0.0, 1.0, -3.0, kBelowPi, -kPi}) EXPECT_EQ(wrap_angle(angle), angle);
}

TEST(WrapAngle, PlusPiBecomesMinusPi) { EXPECT_EQ(wrap_angle(kPi), -kPi); }

TEST(WrapAngle, StaysInTheHalfOpenIntervalAroundEveryEdge) {
  for (int turns = -2000; turns <= 2000; ++turns) {
    const double edge = (2.0 * turns + 1.0) * kPi;
    for (const double angle : {std::nextafter(edge, -1e9), edge, std::nextafter(edge, 1e9)}) {
      const double wrapped = wrap_angle(angle);
      ASSERT_GE(wrapped, -kPi) << angle;
      ASSERT_LT(wrapped, kPi) << angle;
      ASSERT_NEAR(std::abs(wrapped), kPi, 1e-11) << angle;  // 4001 pi has a rounding unit of 2e-12
    }
  }
}

TEST(WrapAngle, KeepsTheDirectionOverManyTurns) {
  constexpr double kTolerance = 1e-12;  // 1000 turns: 6283 rad has a rounding unit of 9e-13
  for (int turns = -1000; turns <= 1000; turns += 125) {
    const double angle = 0.7 + 2.0 * kPi * turns;
    EXPECT_NEAR(wrap_angle(angle), 0.7, kTolerance) << turns;
  }
}

TEST(WrapAngle, WhatHasNoDirectionIsNotANumber) {
  EXPECT_TRUE(std::isnan(wrap_angle(std::nan(""))));
  EXPECT_TRUE(std::isnan(wrap_angle(INFINITY)));
}

TEST(AngleDifference, TakesTheShortWayAcrossTheEdge) {
  // 179 degrees seen from -179 degrees: -2 degrees, not 358.
  const double degree = kPi / 180.0;
  EXPECT_NEAR(angle_difference(179.0 * degree, -179.0 * degree), -2.0 * degree, 1e-15);
  EXPECT_NEAR(angle_difference(-179.0 * degree, 179.0 * degree), 2.0 * degree, 1e-15);
  EXPECT_EQ(angle_difference(0.25, 1.0), -0.75);
}

}  // namespace
}  // namespace ssjs
