#include "ssjs/pipeline/scan_features.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(ScanFeatures, RangesOutsideTheSensorAreLeftOutAndBearingsCorrected) {
  RangeBearingConfig sensor;
  sensor.min_range_m = 1.0;
  sensor.max_range_m = 8.0;
  sensor.bearing_offset_rad = 0.5;
  const Eigen::Matrix2d R = Eigen::Vector2d(0.02, 0.001).asDiagonal();
  const Features scan{{Eigen::Vector2d(0.99, 0.0), R, 1},
                      {Eigen::Vector2d(1.0, 3.0), R, 2},
                      {Eigen::Vector2d(8.0, -0.2), R, std::nullopt},
                      {Eigen::Vector2d(8.01, 0.0), R, 4}};
  const Features usable = usable_features(scan, sensor);
  ASSERT_EQ(usable.size(), 2U);
  EXPECT_NEAR(usable[0].bearing(), 3.5 - 2.0 * kPi, 1e-15);
  EXPECT_EQ(usable[0].landmark_id, 2);
  EXPECT_EQ(usable[0].covariance, R);
  EXPECT_NEAR(usable[1].bearing(), 0.3, 1e-15);
}

/// A trunk of 0.4 m straight ahead: beams of 0.5 degrees, three of them on it.
LaserScan trunk_scan() {
  LaserScan scan{Eigen::VectorXd::Constant(41, 79.0), -10.0 * kPi / 180.0, 0.5 * kPi / 180.0};
  scan.range_m.segment<3>(19).setConstant(12.0);
  return scan;
}

TEST(ScanFeatures, TrunksGetTheConfiguredNoiseAndNoIdentity) {
  RangeBearingConfig sensor;
  sensor.range_sigma_m = 0.2;
  sensor.bearing_sigma_rad = 0.03;
  const Features trunks = detect_features(trunk_scan(), {}, sensor);
  ASSERT_EQ(trunks.size(), 1U);
  EXPECT_NEAR(trunks[0].bearing(), 0.0, 1e-12);
  EXPECT_NEAR(trunks[0].covariance(0, 0), 0.04, 1e-15);
  EXPECT_NEAR(trunks[0].covariance(1, 1), 0.0009, 1e-15);
  EXPECT_EQ(trunks[0].covariance(0, 1), 0.0);
  EXPECT_EQ(trunks[0].landmark_id, std::nullopt);
}

TEST(ScanFeatures, PointTargetsOfASonarAddTheNoiseOfTheSensorToTheirOwn) {
  RangeBearingConfig sensor;
  sensor.range_sigma_m = 0.2;
  sensor.bearing_sigma_rad = 0.03;
  SonarPointConfig config;
  config.centre_sigma_m = 0.1;
  const SonarHits image{{{10.0, -0.01}, {10.0, 0.0}, {10.0, 0.01}}};
  const Features targets = detect_features(image, config, sensor);
  ASSERT_EQ(targets.size(), 1U);
  // No spread in range; in bearing 2e-4 / 9. The centre: 0.1 m, at 10 m 0.01 rad.
  EXPECT_NEAR(targets[0].covariance(0, 0), 0.04 + 0.01, 1e-12);
  EXPECT_NEAR(targets[0].covariance(1, 1), 0.0009 + 0.0001 + 2e-4 / 9.0, 1e-12);
  EXPECT_EQ(observed_features({1.0, image}, {}, config, sensor)->size(), 1U);
  sensor.max_range_m = 9.0;
  EXPECT_EQ(observed_features({1.0, image}, {}, config, sensor)->size(), 0U);
}

TEST(ScanFeatures, OfAnyEvent) {
  const RangeBearingConfig sensor;
  EXPECT_EQ(observed_features({1.0, AckermanControl{}}, {}, {}, sensor), std::nullopt);  // no observation
  EXPECT_EQ(observed_features({1.0, trunk_scan()}, {}, {}, sensor)->size(), 1U);
  EXPECT_EQ(observed_features({1.0, Features{}}, {}, {}, sensor)->size(), 0U);
  LaserScan broken = trunk_scan();
  broken.step_rad = 0.0;
  EXPECT_THROW((void)observed_features({1.0, broken}, {}, {}, sensor), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
