#include "ssjs/optical/keypoints.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(KeypointsTest, V11_ABlobIsFoundWhereItIs) {
  cv::Mat picture(200, 260, CV_8U, cv::Scalar(100));
  cv::circle(picture, {120, 90}, 5, cv::Scalar(200), cv::FILLED, cv::LINE_AA);
  const Keypoints found = find_keypoints(picture, {}, {});
  ASSERT_FALSE(found.points.empty());
  EXPECT_EQ(found.descriptors.rows, static_cast<int>(found.points.size()));
  EXPECT_EQ(found.descriptors.cols, 64);
  EXPECT_LT(cv::norm(found.points[0].position_px - cv::Point2d(120, 90)), 1.5);
}

TEST(KeypointsTest, TheStrongestInsideTheMask) {
  const cv::Mat picture = seabed_picture({320, 240}, 400, 3);
  cv::Mat mask(picture.size(), CV_8U, cv::Scalar(0));
  mask(cv::Rect(40, 60, 100, 90)).setTo(255);
  KeypointConfig config;
  config.max_keypoints = 20;
  const Keypoints all = find_keypoints(picture, {}, {});
  const Keypoints some = find_keypoints(picture, mask, config);
  EXPECT_GT(all.points.size(), 100U);
  ASSERT_EQ(some.points.size(), 20U);
  for (std::size_t i = 0; i < some.points.size(); ++i) {
    EXPECT_TRUE(cv::Rect2d(39, 59, 102, 92).contains(some.points[i].position_px));
    EXPECT_LE(some.points[i].response, some.points[i == 0 ? 0 : i - 1].response);
  }
}

TEST(KeypointsTest, NothingInAFlatFrame) {
  const Keypoints found = find_keypoints(cv::Mat(100, 100, CV_8U, cv::Scalar(128)), {}, {});
  EXPECT_TRUE(found.points.empty());
  EXPECT_TRUE(found.descriptors.empty());
}

TEST(KeypointsTest, TinyFramesAndWrongTypes) {
  for (int side = 1; side < 20; ++side) EXPECT_NO_THROW((void)find_keypoints(cv::Mat(side, side, CV_8U, cv::Scalar(7)), {}, {}));
  EXPECT_THROW((void)find_keypoints(cv::Mat(50, 50, CV_8UC3), {}, {}), InvalidArgument);
  EXPECT_THROW((void)find_keypoints(cv::Mat(), {}, {}), InvalidArgument);
  EXPECT_THROW((void)find_keypoints(cv::Mat(50, 50, CV_8U), cv::Mat(49, 50, CV_8U), {}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
