#include "ssjs/io/log_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ssjs {
namespace {

TEST(LogClock, KnownMoments) {
  EXPECT_EQ(utc_seconds(1970, 1, 1, 0, 0, 0), 0.0);
  EXPECT_EQ(utc_seconds(2001, 9, 9, 1, 46, 40), 1e9);
  EXPECT_EQ(utc_seconds(2020, 2, 29, 0, 0, 0), 18321.0 * 86400.0);
  EXPECT_EQ(utc_seconds(2016, 12, 31, 23, 59, 60), utc_seconds(2017, 1, 1, 0, 0, 0));
}

TEST(LogClock, WhatIsNoDateIsNone) {
  EXPECT_FALSE(utc_seconds(0, 0, 0, 0, 0, 0));
  EXPECT_FALSE(utc_seconds(2019, 2, 29, 0, 0, 0));
  EXPECT_FALSE(utc_seconds(2100, 2, 29, 0, 0, 0));
  EXPECT_FALSE(utc_seconds(2020, 13, 1, 0, 0, 0));
  EXPECT_FALSE(utc_seconds(2020, 4, 31, 0, 0, 0));
  EXPECT_FALSE(utc_seconds(2020, 4, 30, 24, 0, 0));
  EXPECT_FALSE(utc_seconds(2020, 4, 30, 0, 60, 0));
}

TEST(LogClock, TheDayOfATimeIsTheNearest) {
  const double midnight_s = *utc_seconds(2020, 3, 1, 0, 0, 0);
  EXPECT_EQ(time_of_day_near(midnight_s + 1.0, 23, 59, 59), midnight_s - 1.0);
  EXPECT_EQ(time_of_day_near(midnight_s - 1.0, 0, 0, 1), midnight_s + 1.0);
  EXPECT_FALSE(time_of_day_near(std::nan(""), 1, 2, 3));
}

TEST(MillisecondCounter, NarrowsDownItsZero) {
  MillisecondCounter counter(0.01);
  double error_s = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double true_s = 1000.0 + 0.1037 * i;
    const double time_s = counter.refine(std::floor(true_s * 100.0) / 100.0, static_cast<std::uint32_t>((true_s - 990.0) * 1000.0));
    error_s = std::abs(time_s - true_s);
    EXPECT_LE(error_s, 0.0101);
  }
  EXPECT_LE(error_s, 0.002);
  EXPECT_EQ(counter.restarts(), 0U);
}

TEST(MillisecondCounter, StartsAnewWhereTheCounterDoes) {
  MillisecondCounter counter(0.01);
  (void)counter.refine(1000.0, 500000);
  EXPECT_NEAR(counter.refine(1001.0, 12), 1001.0, 0.0101);
  EXPECT_EQ(counter.restarts(), 1U);
}

}  // namespace
}  // namespace ssjs
