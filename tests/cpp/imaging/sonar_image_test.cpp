#include "ssjs/imaging/sonar_image.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(SonarImageTest, RangeIsThatOfTheValidPixels) {
  const cv::Mat intensity = (cv::Mat_<unsigned char>(2, 3) << 9, 20, 30, 40, 50, 255);
  const cv::Mat valid = (cv::Mat_<unsigned char>(2, 3) << 0, 1, 1, 1, 255, 0);
  const std::optional<IntensityRange> range = intensity_range({intensity, valid});
  ASSERT_TRUE(range);
  EXPECT_EQ(range->lowest, 20);
  EXPECT_EQ(range->highest, 50);
  EXPECT_FALSE(intensity_range({intensity, cv::Mat::zeros(2, 3, CV_8U)}));
}

TEST(SonarImageTest, SixteenBitsAreDrawnOutOverTheValidRange) {
  // 1000 -> 0, 3000 -> 255, 2200 -> 255 x 1200 / 2000 = 153; the invalid 65535 does not count.
  const cv::Mat intensity = (cv::Mat_<unsigned short>(1, 4) << 1000, 2200, 3000, 65535);
  const cv::Mat valid = (cv::Mat_<unsigned char>(1, 4) << 1, 1, 1, 0);
  const cv::Mat narrow = in_8_bits({intensity, valid}).intensity;
  const cv::Mat expected = (cv::Mat_<unsigned char>(1, 4) << 0, 153, 255, 0);
  EXPECT_EQ(cv::countNonZero(narrow != expected), 0);
}

TEST(SonarImageTest, AFlatImageOfSixteenBitsBecomesBlack) {
  const cv::Mat narrow = in_8_bits({cv::Mat(4, 4, CV_16U, cv::Scalar(777)), {}}).intensity;
  EXPECT_EQ(narrow.type(), CV_8U);
  EXPECT_EQ(cv::countNonZero(narrow), 0);
}

TEST(SonarImageTest, WhatIsNoSonarImageIsRefused) {
  const cv::Mat good(2, 2, CV_8U, cv::Scalar(1));
  EXPECT_THROW(check_sonar_image({}), InvalidArgument);
  EXPECT_THROW(check_sonar_image({cv::Mat(2, 2, CV_8UC3), {}}), InvalidArgument);
  EXPECT_THROW(check_sonar_image({cv::Mat(2, 2, CV_32F), {}}), InvalidArgument);
  EXPECT_THROW(check_sonar_image({good, cv::Mat(2, 3, CV_8U)}), InvalidArgument);
  EXPECT_THROW(check_sonar_image({good, cv::Mat(2, 2, CV_16U)}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
