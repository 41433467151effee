#include "ssjs/optical/frame_preprocess.hpp"

#include <gtest/gtest.h>

#include "optical/seabed_picture.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// The same seabed under a lamp that lights one corner.
cv::Mat lamp_lit(const cv::Mat& picture) {
  cv::Mat lit(picture.size(), CV_8U);
  for (int r = 0; r < picture.rows; ++r) {
    for (int c = 0; c < picture.cols; ++c) {
      const double light = std::exp(-std::hypot(r - 60.0, c - 80.0) / 160.0);
      lit.at<unsigned char>(r, c) = cv::saturate_cast<unsigned char>(light * picture.at<unsigned char>(r, c));
    }
  }
  return lit;
}

double correlation(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat x, y;
  a.convertTo(x, CV_32F);
  b.convertTo(y, CV_32F);
  x -= cv::mean(x)[0];
  y -= cv::mean(y)[0];
  return x.dot(y) / std::sqrt(x.dot(x) * y.dot(y));
}

TEST(FramePreprocessTest, V6_TheLampGoesTheSeabedStays) {
  const cv::Mat seabed = seabed_picture({320, 240}, 400, 11);
  const cv::Mat lit = lamp_lit(seabed);
  const cv::Mat even = evenly_lit(lit, {});
  EXPECT_LT(correlation(lit, seabed), 0.75);
  EXPECT_GT(correlation(even, seabed), 0.85);
  cv::Scalar mean, sigma;
  cv::meanStdDev(even, mean, sigma);
  EXPECT_NEAR(mean[0], 128.0, 5.0);
  EXPECT_NEAR(sigma[0], 45.0, 10.0);
}

TEST(FramePreprocessTest, AFlatFrameStaysFlat) {
  const cv::Mat even = evenly_lit(cv::Mat(100, 200, CV_8U, cv::Scalar(30)), {});
  double low = 0, high = 0;
  cv::minMaxLoc(even, &low, &high);
  EXPECT_EQ(low, 128.0);
  EXPECT_EQ(high, 128.0);
}

TEST(FramePreprocessTest, V5_Channels) {
  cv::Mat frame(2, 2, CV_8UC3, cv::Scalar(10, 100, 200));  // red, green, blue
  frame.at<cv::Vec3b>(0, 0) = {10, 180, 201};
  EXPECT_EQ(frame_channel(frame, FrameChannel::kRed).at<unsigned char>(1, 1), 10);
  EXPECT_EQ(frame_channel(frame, FrameChannel::kGreen).at<unsigned char>(1, 1), 100);
  EXPECT_EQ(frame_channel(frame, FrameChannel::kBlue).at<unsigned char>(1, 1), 200);
  EXPECT_EQ(frame_channel(frame, FrameChannel::kGrey).at<unsigned char>(1, 1), 84);  // 2.99 + 58.7 + 22.8
  EXPECT_EQ(frame_channel(frame, FrameChannel::kContrast).at<unsigned char>(0, 0), 180);
  EXPECT_THROW((void)frame_channel(cv::Mat(), FrameChannel::kGrey), InvalidArgument);
}

TEST(FramePreprocessTest, QualityTellsDarkFlatAndBlurred) {
  const cv::Mat seabed = seabed_picture({320, 240}, 400, 11);
  cv::Mat blurred;
  cv::GaussianBlur(seabed, blurred, cv::Size(), 6.0);
  const FrameQuality sharp = frame_quality(seabed), soft = frame_quality(blurred);
  EXPECT_LT(soft.sharpness, 0.1 * sharp.sharpness);
  EXPECT_EQ(frame_quality(cv::Mat(10, 10, CV_8U, cv::Scalar(3))).level_sigma, 0.0);
  EXPECT_EQ(frame_quality(cv::Mat(10, 10, CV_8U, cv::Scalar(3))).mean_level, 3.0);
}

}  // namespace
}  // namespace ssjs
