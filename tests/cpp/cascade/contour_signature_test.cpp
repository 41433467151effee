#include "ssjs/cascade/contour_signature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

cv::Mat ellipse(double long_axis, double short_axis, double angle_deg) {
  cv::Mat mask = cv::Mat::zeros(240, 240, CV_8U);
  cv::ellipse(mask,
              cv::RotatedRect({118.0F, 123.0F}, {static_cast<float>(2 * long_axis), static_cast<float>(2 * short_axis)},
                              static_cast<float>(angle_deg)),
              cv::Scalar(255), cv::FILLED);
  return mask;
}

double apart(const ContourSignature& a, const ContourSignature& b) {
  double most = 0;
  for (std::size_t h = 0; h < kContourHarmonics; ++h) most = std::max(most, std::abs(a.spectrum[h] - b.spectrum[h]));
  return most;
}

TEST(ContourSignatureTest, C19_ACircleIsEverywhereEquallyFarFromItsCentre) {
  const auto signature = contour_signature(ellipse(80, 80, 0));
  ASSERT_TRUE(signature);
  for (const double distance : signature->distance) EXPECT_NEAR(distance, 1, 0.015);  // a pixel in 80
  for (const double harmonic : signature->spectrum) EXPECT_LT(harmonic, 0.004);
}

TEST(ContourSignatureTest, C19_ASquareByHand) {
  // Half a side from the centre in the middle of each side, sqrt(2) as much in the corners: four periods a turn.
  cv::Mat mask = cv::Mat::zeros(200, 200, CV_8U);
  mask(cv::Rect(40, 50, 101, 101)).setTo(1);
  const auto signature = contour_signature(mask);
  ASSERT_TRUE(signature);
  const auto [least, most] = std::minmax_element(signature->distance.begin(), signature->distance.end());
  EXPECT_NEAR(*most / *least, std::sqrt(2.0), 0.02);
  for (const std::size_t h : {0U, 1U, 2U, 4U, 5U, 6U})
    EXPECT_LT(signature->spectrum[h], 0.1 * signature->spectrum[3]) << "harmonic " << h + 1;
}

TEST(ContourSignatureTest, C20_ScaleAndRotationChangeNothing) {
  const auto reference = contour_signature(ellipse(90, 40, 0));
  ASSERT_TRUE(reference);
  for (const double angle : {17.0, 45.0, 90.0, 133.0}) EXPECT_LT(apart(*reference, *contour_signature(ellipse(90, 40, angle))), 0.01);
  for (const double scale : {0.4, 0.7, 1.1}) EXPECT_LT(apart(*reference, *contour_signature(ellipse(90 * scale, 40 * scale, 30))), 0.015);
  EXPECT_GT(apart(*reference, *contour_signature(ellipse(90, 70, 0))), 0.05);
}

TEST(ContourSignatureTest, OnlyTheLargestRegionCounts) {
  cv::Mat mask = ellipse(60, 30, 0);
  const auto alone = contour_signature(mask);
  mask(cv::Rect(2, 2, 9, 9)).setTo(255);
  EXPECT_EQ(contour_signature(mask)->spectrum, alone->spectrum);
  EXPECT_FALSE(contour_signature(cv::Mat::zeros(9, 9, CV_8U)));
  cv::Mat line = cv::Mat::zeros(9, 9, CV_8U);
  line.row(4).setTo(1);
  EXPECT_FALSE(contour_signature(line));
  EXPECT_THROW((void)contour_signature(cv::Mat()), InvalidArgument);
}

TEST(ContourSignatureTest, C20_AMirroredObjectHasTheSameSpectrum) {
  cv::Mat mask = ellipse(60, 30, 25);
  mask(cv::Rect(118, 60, 30, 40)).setTo(255);  // a bulge on one side: no symmetry left
  cv::Mat flipped;
  cv::flip(mask, flipped, 1);
  EXPECT_LT(apart(*contour_signature(mask), *contour_signature(flipped)), 0.005);
}

/// Seabed of one level, a bright disc, and its shadow to the right.
cv::Mat disc_with_shadow(int side, unsigned char seabed = 60) {
  cv::Mat picture(side, side, CV_8U, cv::Scalar(seabed));
  const int radius = side / 5;
  cv::rectangle(picture, cv::Rect(side / 2, side / 2 - radius, side / 2 - 2, 2 * radius), cv::Scalar(5), cv::FILLED);
  cv::circle(picture, {side / 2 - side / 10, side / 2}, radius, cv::Scalar(200), cv::FILLED);
  return picture;
}

TEST(ContourSignatureTest, C21_TheEchoIsTheBrighterOfTwoClasses) {
  const auto mask = echo_mask({disc_with_shadow(60), {}}, {0, 0, 60, 60});
  ASSERT_TRUE(mask);
  EXPECT_EQ(mask->size(), cv::Size(kEchoSide, kEchoSide));
  const double scale = kEchoSide / 60.0;
  EXPECT_EQ(mask->at<unsigned char>(cvRound(30 * scale), cvRound(24 * scale)), 255);
  EXPECT_EQ(mask->at<unsigned char>(cvRound(5 * scale), cvRound(5 * scale)), 0);    // seabed
  EXPECT_EQ(mask->at<unsigned char>(cvRound(30 * scale), cvRound(50 * scale)), 0);  // shadow
  EXPECT_NEAR(cv::countNonZero(*mask) / (scale * scale), CV_PI * 12 * 12, 0.1 * CV_PI * 12 * 12);
}

TEST(ContourSignatureTest, C21_TheSizeOfTheBoxDoesNotMatter) {
  const auto large = echo_signature({disc_with_shadow(200), {}}, {0, 0, 200, 200});
  const auto small = echo_signature({disc_with_shadow(40), {}}, {0, 0, 40, 40});
  ASSERT_TRUE(large && small);
  EXPECT_LT(apart(*large, *small), 0.03);
}

TEST(ContourSignatureTest, C21_InvalidPixelsAreNoEcho) {
  cv::Mat picture = disc_with_shadow(60);
  picture(cv::Rect(0, 0, 60, 10)).setTo(255);  // such as a burnt-in text
  cv::Mat valid(60, 60, CV_8U, cv::Scalar(255));
  valid(cv::Rect(0, 0, 60, 10)).setTo(0);
  const auto mask = echo_mask({picture, valid}, {0, 0, 60, 60});
  ASSERT_TRUE(mask);
  EXPECT_EQ(cv::countNonZero(mask->rowRange(0, 10)), 0);
  EXPECT_GT(mask->at<unsigned char>(32, 26), 0);
}

TEST(ContourSignatureTest, NothingToSeeIsNoEcho) {
  const cv::Mat flat(30, 30, CV_8U, cv::Scalar(60));
  EXPECT_FALSE(echo_signature({flat, {}}, {2, 2, 20, 20}));
  EXPECT_THROW((void)echo_mask({flat, {}}, {20, 2, 20, 20}), InvalidArgument);
  EXPECT_THROW((void)echo_mask({flat, {}}, {2, 2, 0, 5}), InvalidArgument);
  EXPECT_THROW((void)echo_mask({cv::Mat(9, 9, CV_16U, cv::Scalar(3)), {}}, {0, 0, 9, 9}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
