#include "ssjs/features/tree_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

constexpr double kStep = kPi / 360.0;  // half a degree
constexpr double kNothing = 81.9;      // m, what the sensor reports without return

struct Circle {
  double x;
  double y;
  double radius;
};

/// What 361 beams from -90 to +90 degrees see of some circles: the nearest intersection of each ray.
LaserScan sweep(const std::vector<Circle>& circles) {
  LaserScan scan{Eigen::VectorXd::Constant(361, kNothing), -0.5 * kPi, kStep};
  for (Eigen::Index beam = 0; beam < 361; ++beam) {
    const double angle = scan.first_angle_rad + static_cast<double>(beam) * kStep;
    for (const Circle& circle : circles) {
      // |t u - c| = r with u the ray: t = u.c - sqrt((u.c)^2 - |c|^2 + r^2)
      const double along = circle.x * std::cos(angle) + circle.y * std::sin(angle);
      const double discriminant = along * along - circle.x * circle.x - circle.y * circle.y + circle.radius * circle.radius;
      if (along > 0.0 && discriminant >= 0.0) scan.range_m(beam) = std::min(scan.range_m(beam), along - std::sqrt(discriminant));
    }
  }
  return scan;
}

/// A scan with returns of the given ranges from `first_beam` on.
LaserScan returns(Eigen::Index first_beam, const std::vector<double>& ranges) {
  LaserScan scan{Eigen::VectorXd::Constant(361, kNothing), -0.5 * kPi, kStep};
  for (std::size_t k = 0; k < ranges.size(); ++k) scan.range_m(first_beam + static_cast<Eigen::Index>(k)) = ranges[k];
  return scan;
}

TEST(TreeDetector, T5_T6_CentreAndDiameterOfDrawnTrunks) {
  Rng rng(61);
  TreeDetectorConfig config;
  config.max_slant = 1.0;  // one boundary beam may graze the trunk while the other hits it squarely
  for (int trial = 0; trial < 200; ++trial) {
    const double bearing = rng.uniform(-1.3, 1.3);
    const double radius = rng.uniform(0.1, 0.5);
    const double range = rng.uniform(4.0, std::min(30.0, 1.9 * radius / kStep));  // a thinner trunk can pass between two beams
    const std::vector<Trunk> trunks = detect_trunks(sweep({{range * std::cos(bearing), range * std::sin(bearing), radius}}), config);
    ASSERT_EQ(trunks.size(), 1u) << "range " << range << " radius " << radius;
    // A boundary is known to one beam: bearing to half a step, diameter to the width of one beam at that range, and the centre to
    // half of that, beyond what the nearest beam misses of the nearest point.
    const double beam_width = range * kStep;
    EXPECT_NEAR(trunks[0].bearing_rad, bearing, 0.5 * kStep + 1e-12);
    EXPECT_NEAR(trunks[0].diameter_m, 2.0 * radius, 1.1 * beam_width);
    EXPECT_NEAR(trunks[0].range_m, range,
                0.55 * beam_width + radius - std::sqrt(std::max(0.0, radius * radius - 0.25 * beam_width * beam_width)));
  }
}

TEST(TreeDetector, T5_T6_ByHand) {
  // Beams 179, 180, 181 at 10 m: half angle 1.5 steps = 0.75 deg, chord 2 * 10 * sin(0.75 deg) = 0.261792, centre at 10.130896 m, ahead.
  const std::vector<Trunk> trunks = detect_trunks(returns(179, {10.0, 10.0, 10.0}), {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].diameter_m, 0.261792, 1e-6);
  EXPECT_NEAR(trunks[0].range_m, 10.130896, 1e-6);
  EXPECT_NEAR(trunks[0].bearing_rad, 0.0, 1e-12);
}

TEST(TreeDetector, T6_MiddleOfAnEvenNumberOfBeamsIsTheMeanOfTwo) {
  // four beams: chord 2 * 10.05 * sin(1 deg) = 0.350794; middle (9.9 + 9.8) / 2 = 9.85
  const std::vector<Trunk> trunks = detect_trunks(returns(100, {10.0, 9.9, 9.8, 10.1}), {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].diameter_m, 0.350794, 1e-6);
  EXPECT_NEAR(trunks[0].range_m, 9.85 + 0.175397, 1e-6);
  EXPECT_NEAR(trunks[0].bearing_rad, -0.5 * kPi + 101.5 * kStep, 1e-12);
}

TEST(TreeDetector, T6_MissingMiddleBeamTakesItsNeighbours) {
  const std::vector<Trunk> trunks = detect_trunks(returns(100, {10.0, 9.8, kNothing, 9.9, 10.0}), {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].range_m - 0.5 * trunks[0].diameter_m, 9.85, 1e-12);
}

TEST(TreeDetector, T1_GapsAndJumpsEndAnObject) {
  TreeDetectorConfig config;
  config.min_clearance_m = 0.0;
  config.max_missing_beams = 1;
  EXPECT_EQ(detect_trunks(returns(100, {10.0, 10.0, kNothing, 10.0}), config).size(), 1u);
  EXPECT_EQ(detect_trunks(returns(100, {10.0, 10.0, kNothing, kNothing, 10.0}), config).size(), 2u);
  // 10 and 12 m are two objects (jump 1.5 m); next to each other, the farther one is covered (T-3)
  const std::vector<Trunk> trunks = detect_trunks(returns(100, {10.0, 10.0, 12.0, 12.0}), config);
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].range_m, 10.0, 0.2);
}

TEST(TreeDetector, T2_CrowdedObjectsAreNoTrunks) {
  // Trunks 20 m ahead and 2 m apart (1.6 m clear), then 4 m apart: clearance 3 m
  EXPECT_TRUE(detect_trunks(sweep({{20.0, -1.0, 0.2}, {20.0, 1.0, 0.2}}), {}).empty());
  EXPECT_EQ(detect_trunks(sweep({{20.0, -2.0, 0.2}, {20.0, 2.0, 0.2}}), {}).size(), 2u);
}

TEST(TreeDetector, T3_HalfCoveredTrunkIsNoTrunk) {
  // The far trunk stands half behind the near one: its visible half would give a wrong centre.
  const std::vector<Trunk> trunks = detect_trunks(sweep({{10.0, 0.0, 0.3}, {20.0, 0.6, 0.4}}), {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].range_m, 10.0, 0.06);
}

TEST(TreeDetector, T4_SlantedSurfaceIsNoTrunk) {
  // six beams, 0.6 m wide at 11.5 m, falling back 1.25 m from one side to the other
  EXPECT_TRUE(detect_trunks(returns(100, {11.0, 11.25, 11.5, 11.75, 12.0, 12.25}), {}).empty());
  EXPECT_EQ(detect_trunks(returns(100, {11.5, 11.4, 11.35, 11.35, 11.4, 11.5}), {}).size(), 1u);
}

TEST(TreeDetector, WideObjectsAndFarOrNearTrunksAreLeftOut) {
  EXPECT_TRUE(detect_trunks(sweep({{10.0, 0.0, 0.8}}), {}).empty());
  EXPECT_TRUE(detect_trunks(sweep({{41.0, 0.0, 0.3}}), {}).empty());
  EXPECT_TRUE(detect_trunks(sweep({{2.5, 0.0, 0.2}}), {}).empty());
  TreeDetectorConfig config;
  config.min_beams = 3;
  EXPECT_TRUE(detect_trunks(returns(100, {20.0, 20.0}), config).empty());
  EXPECT_EQ(detect_trunks(returns(100, {20.0, 20.0, 20.0}), config).size(), 1u);
}

TEST(TreeDetector, ObjectsAtTheBorderOfTheSweepAreLeftOut) {
  EXPECT_TRUE(detect_trunks(returns(0, {20.0, 20.0}), {}).empty());
  EXPECT_TRUE(detect_trunks(returns(359, {20.0, 20.0}), {}).empty());
  EXPECT_EQ(detect_trunks(returns(1, {20.0, 20.0}), {}).size(), 1u);
}

TEST(TreeDetector, MaskedBeamsAreNotLookedAt) {
  LaserScan scan = returns(20, {5.0, 5.0});
  scan.range_m.head(12).setConstant(0.85);  // the vehicle itself
  scan.range_m(10) = 4.0;
  TreeDetectorConfig config;
  config.masked_beams = 12;
  EXPECT_EQ(detect_trunks(scan, config).size(), 1u);
  config.masked_beams = 22;
  EXPECT_TRUE(detect_trunks(scan, config).empty());
  config.masked_beams = 361;
  EXPECT_THROW((void)detect_trunks(scan, config), InvalidArgument);
}

TEST(TreeDetector, AnythingElseIsNoReturn) {
  EXPECT_TRUE(detect_trunks(LaserScan{}, {}).empty());
  EXPECT_TRUE(detect_trunks(sweep({}), {}).empty());
  LaserScan scan = returns(100, {20.0, 20.0});
  const double nothing[] = {std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity(),
                            -1.0,
                            0.0,
                            80.0};
  for (Eigen::Index beam = 0; beam < 100; ++beam) scan.range_m(beam) = nothing[beam % 6];
  for (Eigen::Index beam = 102; beam < 361; ++beam) scan.range_m(beam) = nothing[beam % 6];
  const std::vector<Trunk> trunks = detect_trunks(scan, {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(trunks[0].bearing_rad, -0.5 * kPi + 100.5 * kStep, 1e-12);
  scan.range_m.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(detect_trunks(scan, {}).empty());
}

TEST(TreeDetector, ClockwiseSweepSeesTheMirrorImage) {
  const LaserScan scan = sweep({{10.0, 4.0, 0.3}, {15.0, -3.0, 0.25}, {8.0, 0.3, 0.2}});
  LaserScan mirrored = scan;
  mirrored.first_angle_rad = -scan.first_angle_rad;
  mirrored.step_rad = -scan.step_rad;
  const std::vector<Trunk> trunks = detect_trunks(scan, {});
  const std::vector<Trunk> mirror = detect_trunks(mirrored, {});
  ASSERT_EQ(trunks.size(), 3u);
  ASSERT_EQ(mirror.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(mirror[k].range_m, trunks[k].range_m);
    EXPECT_NEAR(mirror[k].bearing_rad, -trunks[k].bearing_rad, 1e-12);
    EXPECT_EQ(mirror[k].diameter_m, trunks[k].diameter_m);
  }
}

TEST(TreeDetector, BearingsStayInOneTurn) {
  LaserScan scan = returns(180, {10.0});
  scan.first_angle_rad = 0.5 * kPi;  // beam 180 looks straight back
  const std::vector<Trunk> trunks = detect_trunks(scan, {});
  ASSERT_EQ(trunks.size(), 1u);
  EXPECT_NEAR(std::abs(trunks[0].bearing_rad), kPi, 1e-12);
  EXPECT_LT(trunks[0].bearing_rad, kPi);
}

TEST(TreeDetector, RefusesContradictions) {
  const LaserScan scan = sweep({});
  TreeDetectorConfig config;
  config.min_range_m = 50.0;
  EXPECT_THROW((void)detect_trunks(scan, config), InvalidArgument);
  config = {};
  config.min_diameter_m = 2.0;
  EXPECT_THROW((void)detect_trunks(scan, config), InvalidArgument);
  config = {};
  config.min_beams = 0;
  EXPECT_THROW((void)detect_trunks(scan, config), InvalidArgument);
  LaserScan still = scan;
  still.step_rad = 0.0;
  EXPECT_THROW((void)detect_trunks(still, {}), InvalidArgument);
  still = scan;
  still.first_angle_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)detect_trunks(still, {}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
