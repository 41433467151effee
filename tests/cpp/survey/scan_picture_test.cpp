#include "ssjs/survey/scan_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/imaging/segmentation.hpp"

namespace ssjs {
namespace {

ScanPictureConfig smooth() {
  ScanPictureConfig config;
  config.looks = config.echo_looks = 255;
  return config;
}

HeardEcho stone(double x_m, double y_m, double shadow_m = 0.0) {
  HeardEcho heard;
  heard.echo = {2.0, 1.0, 0.0, 220.0, shadow_m};
  heard.vehicle_p_echo << x_m, y_m;
  return heard;
}

int level_at(const SonarImage& picture, double x_m, double y_m, const ScanPictureConfig& config) {
  const cv::Point2d place = picture_point({x_m, y_m}, config);
  return picture.intensity.at<unsigned char>(static_cast<int>(std::lround(place.y)), static_cast<int>(std::lround(place.x)));
}

TEST(ScanPictureTest, Q3_AheadIsUpAndPortIsLeft) {
  const ScanPictureConfig config;
  const cv::Point2d ahead_and_port = picture_point({10.0, 4.0}, config);
  EXPECT_DOUBLE_EQ(ahead_and_port.y, 100.0);  // 150 - 10 / 0.2
  EXPECT_DOUBLE_EQ(ahead_and_port.x, 130.0);  // 150 - 4 / 0.2
  const Eigen::Vector2d back = vehicle_point({130.25, 99.5}, config);
  EXPECT_NEAR(back.x(), 10.1, 1e-12);
  EXPECT_NEAR(back.y(), 3.95, 1e-12);
}

TEST(ScanPictureTest, Q1_Q2_AnEchoIsBrightAndItsShadowLiesBehindIt) {
  const ScanPictureConfig config = smooth();
  const SonarImage picture = scan_picture({stone(6.0, 8.0, 3.0)}, Se2(), config, Rng(1));
  EXPECT_NEAR(level_at(picture, 6.0, 8.0, config), 220, 45);
  EXPECT_NEAR(level_at(picture, 7.2, 9.6, config), 11, 5);    // 12 m away, of 10 to 13
  EXPECT_NEAR(level_at(picture, 8.4, 11.2, config), 55, 15);  // 14 m away
  EXPECT_NEAR(level_at(picture, 4.8, 6.4, config), 55, 15);   // before it
  EXPECT_NEAR(level_at(picture, 9.6, 7.2, config), 55, 15);   // 12 m away, beside the shadow
}

TEST(ScanPictureTest, Q2_ANearShadowHidesAFarEcho) {
  const ScanPictureConfig config = smooth();
  const SonarImage picture = scan_picture({stone(12.0, 0.0), stone(9.0, 0.0, 5.0)}, Se2(), config, Rng(1));
  EXPECT_LT(level_at(picture, 12.0, 0.0, config), 30);
  EXPECT_GT(level_at(picture, 9.0, 0.0, config), 150);
}

TEST(ScanPictureTest, Q1_AnEchoTurnsAgainstTheVehicle) {
  const ScanPictureConfig config = smooth();
  HeardEcho bar = stone(10.0, 0.0);
  bar.echo.aspect = 4.0;  // 1.6 m to each end along x of the global frame
  EXPECT_GT(level_at(scan_picture({bar}, Se2(), config, Rng(1)), 11.4, 0.0, config), 150);
  const SonarImage turned = scan_picture({bar}, Se2{5.0, 5.0, 0.5 * kPi}, config, Rng(1));
  EXPECT_LT(level_at(turned, 11.4, 0.0, config), 100);
  EXPECT_GT(level_at(turned, 10.0, 1.4, config), 150);
}

TEST(ScanPictureTest, NothingIsValidOutsideTheRanges) {
  const ScanPictureConfig config;
  const SonarImage picture = scan_picture({}, Se2(), config, Rng(1));
  EXPECT_EQ(picture.valid.at<unsigned char>(150, 150), 0);
  EXPECT_EQ(picture.valid.at<unsigned char>(150, 160), 255);
  EXPECT_EQ(picture.valid.at<unsigned char>(2, 2), 0);
  EXPECT_EQ(picture.intensity.at<unsigned char>(2, 2), 0);
}

TEST(ScanPictureTest, Q4_TheCentroidScattersNoMoreThanItClaims) {
  const ScanPictureConfig config;
  const SegmentationConfig segmentation = segmentation_preset(SegmentationPreset::kSideScanLow);
  Rng places(7);
  double squares = 0.0, claimed = 0.0;
  int found = 0;
  for (int i = 0; i < 60; ++i) {
    const HeardEcho heard = stone(places.uniform(8.0, 12.0), places.uniform(-12.0, 12.0));
    const SegmentationResult result = segment(scan_picture({heard}, Se2(), config, Rng(11).stream(std::to_string(i))), segmentation);
    for (const Region& region : result.regions.regions) {
      const Eigen::Vector2d error = vehicle_point(region.centroid_px, config) - heard.vehicle_p_echo;
      if (error.norm() > heard.echo.radius_m()) continue;
      squares += 0.5 * error.squaredNorm();
      claimed += std::pow(centroid_sigma_m(region.area_px, config), 2);
      ++found;
    }
  }
  ASSERT_GE(found, 55);
  EXPECT_LT(squares / claimed, 1.5);
  EXPECT_GT(squares / claimed, 0.5);
}

TEST(ScanPictureTest, Q5_TheCovarianceHoldsSensorAndCentroid) {
  const ScanPictureConfig config;
  Region region;
  region.area_px = 50;
  region.centroid_px = {150.0, 50.0};  // 20 m ahead
  Eigen::Matrix2d sensor;
  sensor << 0.01, 0.0, 0.0, 0.0003;
  const Feature feature = region_feature(region, sensor, config);
  EXPECT_NEAR(feature.range(), 20.0, 1e-12);
  EXPECT_NEAR(feature.bearing(), 0.0, 1e-12);
  // radius sqrt(50 / pi) = 3.9894 px, variance 0.04 * 4 / (4 pi 3.9894) = 0.0031915 m2
  EXPECT_NEAR(feature.covariance(0, 0), 0.01 + 0.0031915, 1e-7);
  EXPECT_NEAR(feature.covariance(1, 1), 0.0003 + 0.0031915 / 400.0, 1e-9);
  EXPECT_EQ(feature.covariance(0, 1), 0.0);
}

TEST(ScanPictureTest, RefusesWhatContradictsItself) {
  ScanPictureConfig config;
  config.min_range_m = 40.0;
  EXPECT_THROW((void)scan_picture({}, Se2(), config, Rng(1)), InvalidArgument);
  Region middle;
  middle.area_px = 20;
  middle.centroid_px = {150.0, 150.0};
  EXPECT_THROW((void)region_feature(middle, Eigen::Matrix2d::Identity(), ScanPictureConfig()), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
