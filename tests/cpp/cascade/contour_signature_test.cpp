#include "ssjs/cascade/contour_signature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "cascade/speckle.hpp"
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
  for (std::size_t h = 0; h < ContourSignature::kHarmonics; ++h) most = std::max(most, std::abs(a.spectrum[h] - b.spectrum[h]));
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

TEST(ContourSignatureTest, AModelKnowsItsKindFromOthers) {
  Rng rng(4);
  std::vector<ContourSignature> objects;
  for (int i = 0; i < 40; ++i) {
    const double size = rng.uniform(50, 90);
    objects.push_back(*contour_signature(ellipse(size, size * rng.uniform(0.45, 0.55), rng.uniform(0, 180))));
  }
  const SignatureModel model = learn_signature({objects.begin(), objects.begin() + 30});
  for (std::size_t i = 30; i < 40; ++i) EXPECT_LT(unlikeness(objects[i], model), 2);
  EXPECT_GT(unlikeness(*contour_signature(ellipse(80, 76, 10)), model), 3);
  EXPECT_THROW((void)learn_signature({objects[0]}), InvalidArgument);
}

TEST(ContourSignatureTest, TheHighlightOfAnObjectIsItsEcho) {
  Rng rng(2);
  cv::Mat picture(60, 60, CV_8U, cv::Scalar(60));
  cv::circle(picture, {30, 30}, 12, cv::Scalar(200), cv::FILLED);
  const cv::Mat mask = highlight_mask(picture);
  EXPECT_EQ(mask.at<unsigned char>(30, 30), 255);
  EXPECT_EQ(mask.at<unsigned char>(5, 5), 0);
  EXPECT_NEAR(cv::countNonZero(mask), CV_PI * 12 * 12, 40);
}

}  // namespace
}  // namespace ssjs
