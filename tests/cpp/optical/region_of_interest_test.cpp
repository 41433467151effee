#include "ssjs/optical/region_of_interest.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/optical/frame_preprocess.hpp"

namespace ssjs {
namespace {

const cv::Rect kRock(180, 90, 60, 50);

/// Sand of one hue with grain, and a rock: rough, and of another hue where `rock_hue` says so.
cv::Mat scene(bool has_rock, bool has_hue) {
  Rng rng(5);
  cv::Mat frame(240, 320, CV_8UC3);
  for (int r = 0; r < frame.rows; ++r) {
    for (int c = 0; c < frame.cols; ++c) {
      const double grain = rng.normal(2.0);
      frame.at<cv::Vec3b>(r, c) = {cv::saturate_cast<unsigned char>(40 + grain), cv::saturate_cast<unsigned char>(120 + grain),
                                   cv::saturate_cast<unsigned char>(110 + grain)};
    }
  }
  if (!has_rock) return frame;
  const cv::Scalar body = has_hue ? cv::Scalar(130, 60, 40) : cv::Scalar(20, 60, 55);
  const cv::Scalar spot = has_hue ? cv::Scalar(190, 90, 60) : cv::Scalar(60, 180, 165);
  cv::ellipse(frame, {kRock.x + kRock.width / 2, kRock.y + kRock.height / 2}, {kRock.width / 2, kRock.height / 2}, 0, 0, 360, body,
              cv::FILLED);
  for (int i = 0; i < 12; ++i) {
    const cv::Point at(static_cast<int>(rng.uniform(kRock.x + 15, kRock.x + 45)),
                       static_cast<int>(rng.uniform(kRock.y + 10, kRock.y + 40)));
    cv::circle(frame, at, 3, spot, cv::FILLED);
  }
  return frame;
}

RegionsOfInterest found_in(const cv::Mat& frame) {
  return regions_of_interest(frame, evenly_bright(frame_channel(frame, FrameChannel::kGrey), {}), {});
}

TEST(RegionOfInterestTest, V10_ARockOfAnotherHueIsOneRegion) {
  const RegionsOfInterest found = found_in(scene(true, true));
  ASSERT_EQ(found.labelled.regions.size(), 1U);
  const cv::Rect box = found.labelled.regions[0].bounding_box;
  EXPECT_GT((box & kRock).area(), 0.8 * kRock.area());
  EXPECT_LT(box.area(), 2.0 * kRock.area());
}

TEST(RegionOfInterestTest, BareSandHasNone) {
  const RegionsOfInterest found = found_in(scene(false, false));
  EXPECT_TRUE(found.labelled.regions.empty());
}

TEST(RegionOfInterestTest, V9_AHueOnEitherSideOfTheSeam) {
  // mean hue 0 (red): 350 and 10 degrees are alike, 180 is not
  cv::Mat frame(100, 100, CV_8UC3, cv::Scalar(200, 0, 33));
  frame.colRange(0, 50).setTo(cv::Scalar(200, 33, 0));
  frame(cv::Rect(30, 30, 30, 30)).setTo(cv::Scalar(0, 200, 200));
  const cv::Mat mask = hue_regions(frame, {});
  EXPECT_NEAR(cv::countNonZero(mask), 900, 150);
  EXPECT_EQ(cv::countNonZero(mask(cv::Rect(32, 32, 26, 26))), 26 * 26);
}

TEST(RegionOfInterestTest, AGreyFrameIsLeftToTheEdges) {
  cv::Mat grey;
  cv::cvtColor(scene(true, false), grey, cv::COLOR_RGB2GRAY);
  const RegionsOfInterest found = regions_of_interest(grey, evenly_bright(grey, {}), {});
  EXPECT_TRUE(found.hue_mask.empty());
  ASSERT_EQ(found.labelled.regions.size(), 1U);
  cv::Mat three;
  cv::cvtColor(grey, three, cv::COLOR_GRAY2RGB);
  EXPECT_TRUE(regions_of_interest(three, evenly_bright(grey, {}), {}).hue_mask.empty());  // three equal channels have no hue either
}

TEST(RegionOfInterestTest, V8_EdgesThatEncloseNothingAreNone) {
  cv::Mat picture(240, 320, CV_8U, cv::Scalar(100));
  cv::line(picture, {20, 120}, {300, 125}, cv::Scalar(220), 1);
  RegionOfInterestConfig config;
  config.smallest_area = 0.02;
  EXPECT_EQ(cv::countNonZero(edge_regions(picture, config)), 0);
}

}  // namespace
}  // namespace ssjs
