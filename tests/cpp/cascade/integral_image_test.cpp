#include "ssjs/cascade/integral_image.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "cascade/speckle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(IntegralImageTest, C1_SumsOfASmallImageByHand) {
  const cv::Mat image = (cv::Mat_<unsigned char>(2, 3) << 1, 2, 3, 4, 5, 6);
  const IntegralImage integral(image);
  EXPECT_EQ(integral.sum_in({0, 0, 3, 2}), 21U);
  EXPECT_EQ(integral.sum_in({1, 0, 2, 1}), 5U);
  EXPECT_EQ(integral.sum_in({1, 1, 2, 1}), 11U);
  EXPECT_EQ(integral.squares_in({1, 1, 2, 1}), 61U);  // 25 + 36
}

/// The definition of (C-2), pixel by pixel.
std::uint32_t triangle(const cv::Mat& image, int corner_x, int corner_y) {
  std::uint32_t sum = 0;
  for (int y = 0; y < corner_y; ++y)
    for (int x = 0; x < image.cols; ++x)
      if (std::abs(x - corner_x + 1) <= corner_y - y - 1) sum += image.at<unsigned char>(y, x);
  return sum;
}

TEST(IntegralImageTest, C2_TrianglesAreTheSumsOfTheirPixels) {
  Rng rng(3);
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 4), cv::Size(5, 1), cv::Size(2, 2), cv::Size(9, 7), cv::Size(6, 13)}) {
    const cv::Mat image = speckle(size, rng);
    const IntegralImage integral(image, IntegralImage::Diagonal::kWith);
    for (int y = 0; y <= size.height; ++y)
      for (int x = 0; x <= size.width; ++x)
        EXPECT_EQ(integral.diagonal()[integral.offset(x, y)], triangle(image, x, y)) << size << " at " << x << " " << y;
  }
}

TEST(IntegralImageTest, EqualsOpenCv) {
  Rng rng(4);
  const cv::Mat image = speckle({57, 43}, rng, 200);
  const IntegralImage integral(image, IntegralImage::Diagonal::kWith);
  cv::Mat sum;
  cv::Mat squares;
  cv::Mat diagonal;
  cv::integral(image, sum, squares, diagonal, CV_32S, CV_32S);
  for (int y = 0; y <= image.rows; ++y)
    for (int x = 0; x <= image.cols; ++x) {
      const auto at = integral.offset(x, y);
      ASSERT_EQ(static_cast<int>(integral.sum()[at]), sum.at<int>(y, x));
      ASSERT_EQ(static_cast<int>(integral.squares()[at]), squares.at<int>(y, x));
      ASSERT_EQ(static_cast<int>(integral.diagonal()[at]), diagonal.at<int>(y, x));
    }
}

TEST(IntegralImageTest, InterleavedPlanesHoldTheSameSums) {
  Rng rng(5);
  const cv::Mat image = speckle({31, 18}, rng);
  const IntegralImage plain(image, IntegralImage::Diagonal::kWith);
  for (int step = 2; step <= 4; ++step) {
    const IntegralImage split(image, IntegralImage::Diagonal::kWith, step);
    for (const cv::Rect rect : {cv::Rect(0, 0, 31, 18), cv::Rect(3, 2, 7, 5), cv::Rect(30, 17, 1, 1), cv::Rect(11, 0, 12, 9)}) {
      EXPECT_EQ(split.sum_in(rect), plain.sum_in(rect));
      EXPECT_EQ(split.squares_in(rect), plain.squares_in(rect));
    }
    EXPECT_EQ(split.diagonal_sum_in({15, 2, 6, 5}), plain.diagonal_sum_in({15, 2, 6, 5}));
    EXPECT_EQ(split.offset(step, 3), split.offset(0, 3) + 1);  // windows `step` apart are neighbours
  }
}

TEST(IntegralImageTest, SumsStayExactWhenTheRunningSumsOverflow) {
  // 255^2 x 300 x 300 = 5.85e9 passes 2^32; the square of one row of ten pixels does not.
  const IntegralImage integral(cv::Mat(300, 300, CV_8U, cv::Scalar(255)));
  EXPECT_EQ(integral.squares_in({290, 299, 10, 1}), 10U * 255U * 255U);
}

TEST(IntegralImageTest, WhatIsNoGreyImageIsRefused) {
  EXPECT_THROW(IntegralImage{cv::Mat()}, InvalidArgument);
  EXPECT_THROW(IntegralImage(cv::Mat(2, 2, CV_16U)), InvalidArgument);
  EXPECT_THROW(IntegralImage(cv::Mat(2, 2, CV_8U), IntegralImage::Diagonal::kWithout, 0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
