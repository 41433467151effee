#include "ssjs/optical/frame_reader.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

cv::Mat sand_with_a_rock() {
  cv::Mat frame(240, 320, CV_8U);
  Rng rng(9);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.cols; ++c) frame.at<unsigned char>(r, c) = cv::saturate_cast<unsigned char>(120 + rng.normal(3.0));
  }
  cv::circle(frame, {150, 120}, 45, cv::Scalar(70), cv::FILLED);
  for (int i = 0; i < 25; ++i) {
    const cv::Point at(static_cast<int>(rng.uniform(120, 180)), static_cast<int>(rng.uniform(90, 150)));
    cv::circle(frame, at, 3, cv::Scalar(rng.uniform(20, 220)), cv::FILLED);
  }
  return frame;
}

TEST(FrameReaderTest, KeypointsKnowTheirRegion) {
  const FrameFeatures features = FrameReader({}).read(sand_with_a_rock());
  ASSERT_EQ(features.regions.size(), 1U);
  ASSERT_GT(features.keypoints.points.size(), 5U);
  ASSERT_EQ(features.region_of.size(), features.keypoints.points.size());
  for (const int label : features.region_of) EXPECT_EQ(label, 1);
  EXPECT_FALSE(features.left_out);
}

TEST(FrameReaderTest, TheWholeFrameWhereThereIsNoRegionOrWhereAskedFor) {
  FrameReaderConfig config;
  config.regions.smallest_area = 0.5;  // nothing is so large
  const FrameFeatures bare = FrameReader(config).read(sand_with_a_rock());
  EXPECT_TRUE(bare.regions.empty());
  EXPECT_FALSE(bare.keypoints.points.empty());
  for (const int label : bare.region_of) EXPECT_EQ(label, 0);
  config = {};
  config.places = KeypointPlaces::kFrame;
  const FrameFeatures all = FrameReader(config).read(sand_with_a_rock());
  EXPECT_GT(std::count(all.region_of.begin(), all.region_of.end(), 0), 0);
  EXPECT_GT(std::count(all.region_of.begin(), all.region_of.end(), 1), 0);
}

TEST(FrameReaderTest, DarkBlankAndBlurredFramesSayWhy) {
  const FrameReader reader({});
  cv::Mat dark, blurred;
  sand_with_a_rock().convertTo(dark, CV_8U, 0.03);
  cv::GaussianBlur(sand_with_a_rock(), blurred, cv::Size(), 8.0);
  EXPECT_EQ(reader.read(dark).left_out->substr(0, 5), "dark:");
  EXPECT_EQ(reader.read(cv::Mat(240, 320, CV_8U, cv::Scalar(90))).left_out->substr(0, 6), "blank:");
  EXPECT_EQ(reader.read(blurred).left_out->substr(0, 8), "blurred:");
  EXPECT_TRUE(reader.read(blurred).keypoints.points.empty());
}

TEST(FrameReaderTest, BordersOfACorrectedFrameHoldNoKeypoints) {
  CameraCalibration calibration{{320, 240, 300.0, 300.0, 160.0, 120.0}, 0.0, LensModel::kBrown, {0.2, 0.0, 0.0, 0.0, 0.0}};
  FrameReaderConfig config;
  config.places = KeypointPlaces::kFrame;
  const FrameReader reader(config, calibration);
  const cv::Mat seen = Undistortion(calibration).valid();
  const FrameFeatures features = reader.read(seabed_picture({320, 240}, 400, 3));
  ASSERT_LT(cv::countNonZero(seen), 320 * 240);
  for (const Keypoint& keypoint : features.keypoints.points) {
    EXPECT_NE(seen.at<unsigned char>(static_cast<int>(std::lround(keypoint.position_px.y)),
                                     static_cast<int>(std::lround(keypoint.position_px.x))),
              0);
  }
  EXPECT_THROW((void)reader.read(cv::Mat(100, 100, CV_8U, cv::Scalar(0))), InvalidArgument);
}

TEST(FrameReaderTest, EveryViolationIsListed) {
  FrameReaderConfig config;
  config.light.light_scale = 2.0;
  config.keypoints.max_keypoints = 0;
  try {
    const FrameReader reader(config);
    FAIL();
  } catch (const InvalidArgument& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("light.light_scale"), std::string::npos);
    EXPECT_NE(text.find("keypoints.max_keypoints"), std::string::npos);
  }
}

}  // namespace
}  // namespace ssjs
