#include "ssjs/features/sonar_point_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// Hits at even steps of bearing along an arc, as a thin target gives them.
void add_streak(SonarHits& image, double range_m, double bearing_rad, double width_rad, int hits) {
  for (int i = 0; i < hits; ++i) {
    image.range_bearing.emplace_back(range_m, bearing_rad + width_rad * (static_cast<double>(i) / (hits - 1) - 0.5));
  }
}

TEST(SonarPointDetector, F2_F3_CentreExtentAndCovarianceByHand) {
  // Ranges 20.0, 20.1, 20.2 m: mean 20.1; bearings 0.10, 0.11, 0.12 rad: mean 0.11. Scatter sums: range 0.02 m2, bearing 2e-4 rad2, both
  // 2e-3 m rad; over n^2 = 9. The target lies within 0.15 m of the centre: 0.0225 m2, and (0.15 / 20.1)^2 rad2.
  const SonarHits image{{{20.1, 0.11}, {20.0, 0.10}, {20.2, 0.12}}};
  const std::vector<SonarPoint> points = detect_sonar_points(image, {});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].hits, 3);
  EXPECT_NEAR(points[0].range_bearing.x(), 20.1, 1e-12);
  EXPECT_NEAR(points[0].range_bearing.y(), 0.11, 1e-12);
  EXPECT_NEAR(points[0].depth_m, 0.2, 1e-12);
  EXPECT_NEAR(points[0].width_m, 20.1 * 0.02, 1e-12);
  EXPECT_NEAR(points[0].covariance(0, 0), 0.02 / 9.0 + 0.0225, 1e-12);
  EXPECT_NEAR(points[0].covariance(1, 1), 2e-4 / 9.0 + std::pow(0.15 / 20.1, 2), 1e-12);
  EXPECT_NEAR(points[0].covariance(0, 1), 2e-3 / 9.0, 1e-12);
}

TEST(SonarPointDetector, F1_LinksInTheGeometryOfTheSonar) {
  // Two steps of 0.025 rad are 1 m apart at 40 m, and yet one object; 0.5 m of range between the same bearings are two.
  SonarHits wide;
  add_streak(wide, 40.0, 0.0, 0.05, 3);
  EXPECT_EQ(detect_sonar_points(wide, {}).size(), 1U);
  SonarHits deep;
  add_streak(deep, 40.0, 0.0, 0.05, 3);
  add_streak(deep, 40.5, 0.0, 0.05, 3);
  EXPECT_EQ(detect_sonar_points(deep, {}).size(), 2U);
  // Near the sonar the arc counts: 0.5 m at 5 m is 0.1 rad, four times the angle of a link.
  SonarHits near;
  add_streak(near, 5.0, 0.0, 0.2, 3);
  EXPECT_EQ(detect_sonar_points(near, {}).size(), 1U);
}

TEST(SonarPointDetector, F1_TheReachOfALinkIsAnEllipse) {
  SonarPointConfig config;
  config.min_hits = 2;
  config.link_range_m = 0.4;
  config.link_bearing_rad = 0.03;
  // Half of one and half of the other: 0.25 + 0.25 <= 1. Nine tenths of both: 1.62 > 1.
  EXPECT_EQ(detect_sonar_points({{{30.0, 0.0}, {30.2, 0.015}}}, config).size(), 1U);
  EXPECT_EQ(detect_sonar_points({{{30.0, 0.0}, {30.36, 0.027}}}, config).size(), 0U);
}

TEST(SonarPointDetector, F2_WallsHullsAndSingleEchoesAreNoPoints) {
  SonarHits wall;
  add_streak(wall, 30.0, 0.0, 0.4, 21);  // 12 m along the arc
  SonarHits slanted;
  for (int i = 0; i < 20; ++i) slanted.range_bearing.emplace_back(20.0 + 0.1 * i, 0.01 * i);  // 1.9 m deep
  EXPECT_TRUE(detect_sonar_points(wall, {}).empty());
  EXPECT_TRUE(detect_sonar_points(slanted, {}).empty());
  EXPECT_TRUE(detect_sonar_points({{{20.0, 0.0}, {20.1, 0.0}}}, {}).empty());  // two hits, three are asked for
  EXPECT_TRUE(detect_sonar_points({}, {}).empty());
}

TEST(SonarPointDetector, F2_WidthIsJudgedInMetresAndInAngle) {
  SonarPointConfig config;
  config.link_bearing_rad = 0.06;
  config.link_arc_m = 1.2;
  const auto found = [&](double range_m, double width_m) {
    SonarHits image;
    add_streak(image, range_m, 0.0, width_m / range_m, 4);
    return detect_sonar_points(image, config).size();
  };
  EXPECT_EQ(found(5.0, 1.1), 1U);  // 0.22 rad, but below 1.2 m
  EXPECT_EQ(found(5.0, 1.3), 0U);
  EXPECT_EQ(found(20.0, 1.7), 1U);  // 0.0873 rad at 20 m are 1.75 m
  EXPECT_EQ(found(20.0, 1.8), 0U);
  EXPECT_EQ(found(45.0, 2.4), 1U);  // 3.9 m there, 2.5 m at most
  EXPECT_EQ(found(45.0, 2.6), 0U);
}

TEST(SonarPointDetector, PilesAreFoundAmongNoiseInAnyOrderOfTheHits) {
  Rng rng(17);
  std::vector<Eigen::Vector2d> piles;
  for (int row = 0; row < 8; ++row) piles.emplace_back(8.0 + 3.0 * row, -0.6 + 0.15 * row);
  SonarHits image;
  for (const Eigen::Vector2d& pile : piles) {
    for (int i = 0; i < 7; ++i) image.range_bearing.emplace_back(pile.x() + rng.uniform(-0.1, 0.1), pile.y() + rng.uniform(-0.01, 0.01));
  }
  const std::vector<SonarPoint> points = detect_sonar_points(image, {});
  ASSERT_EQ(points.size(), piles.size());
  for (std::size_t i = 0; i < piles.size(); ++i) {
    EXPECT_NEAR(points[i].range_bearing.x(), piles[i].x(), 0.1);
    EXPECT_NEAR(points[i].range_bearing.y(), piles[i].y(), 0.01);
  }
  std::reverse(image.range_bearing.begin(), image.range_bearing.end());
  const std::vector<SonarPoint> again = detect_sonar_points(image, {});
  ASSERT_EQ(again.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(again[i].range_bearing, points[i].range_bearing);
}

TEST(SonarPointDetector, RefusesHitsThatAreNone) {
  EXPECT_THROW((void)detect_sonar_points({{{std::numeric_limits<double>::quiet_NaN(), 0.0}}}, {}), InvalidArgument);
  EXPECT_THROW((void)detect_sonar_points({{{0.0, 0.1}}}, {}), InvalidArgument);
  SonarPointConfig config;
  config.min_hits = 0;
  EXPECT_THROW((void)detect_sonar_points({}, config), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
