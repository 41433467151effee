#include "ssjs/imaging/preprocess.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/imaging/speckle_filter.hpp"

namespace ssjs {
namespace {

template <class Pixel>
cv::Mat noise(Rng& rng, int rows, int columns, double scale) {
  cv::Mat_<Pixel> image(rows, columns);
  for (Pixel& level : image) level = static_cast<Pixel>(scale * (20 + 200 * rng.uniform() * rng.uniform()));
  return cv::Mat(image);
}

bool same(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && a.type() == b.type() && cv::countNonZero(a != b) == 0; }

SpeckleFilterConfig median(int side) {
  SpeckleFilterConfig config;
  config.kind = SpeckleFilter::kMedian;
  config.median_px = side;
  return config;
}

SpeckleFilterConfig gaussian(double sigma_px) {
  SpeckleFilterConfig config;
  config.kind = SpeckleFilter::kGaussian;
  config.sigma_px = sigma_px;
  return config;
}

SpeckleFilterConfig bilateral(double sigma_px, double sigma_levels) {
  SpeckleFilterConfig config;
  config.kind = SpeckleFilter::kBilateral;
  config.sigma_px = sigma_px;
  config.sigma_levels = sigma_levels;
  return config;
}

TEST(PreprocessTest, O6_PowerLawByHand) {
  // 0.1 x^1.415: 10 -> 2.60, 50 -> 25.35, 100 -> 67.61, 200 -> 180.29, 255 -> 254.24. With factor 1, 51 = 260.7 is cut at 255.
  const cv::Mat image = (cv::Mat_<unsigned char>(1, 6) << 0, 10, 50, 100, 200, 255);
  EXPECT_TRUE(same(power_law({image, {}}, {}), (cv::Mat_<unsigned char>(1, 6) << 0, 3, 25, 68, 180, 254)));
  const cv::Mat saturated = power_law({(cv::Mat_<unsigned char>(1, 2) << 50, 51), {}}, {true, 1, 1.415});
  EXPECT_TRUE(same(saturated, (cv::Mat_<unsigned char>(1, 2) << 254, 255)));
  EXPECT_TRUE(same(power_law({image, {}}, {false, 0.1, 1.415}), image));
  EXPECT_THROW((void)power_law({image, {}}, {true, 0, 1.415}), InvalidArgument);
}

TEST(PreprocessTest, O6_SixteenBitsAreNotRoundedBeforeThePowerLaw) {
  // Valid range 0..51000 is 200 levels a level: 20100 -> 100.5 -> 0.1 x 100.5^1.415 = 68.09; 20500 -> 102.5 -> 70.01.
  // Rounded to 101 first, 100.5 would be 68.57 -> 69; 102.5, to 102 or 103, 69.5 or 70.5.
  const cv::Mat image = (cv::Mat_<unsigned short>(1, 5) << 0, 20100, 20500, 51000, 65535);
  const cv::Mat valid = (cv::Mat_<unsigned char>(1, 5) << 1, 1, 1, 1, 0);
  EXPECT_TRUE(same(power_law({image, valid}, {}), (cv::Mat_<unsigned char>(1, 5) << 0, 68, 70, 254, 0)));
  EXPECT_EQ(cv::countNonZero(power_law({cv::Mat(3, 3, CV_16U, cv::Scalar(700)), {}}, {})), 0);
  EXPECT_EQ(cv::countNonZero(power_law({image, cv::Mat::zeros(1, 5, CV_8U)}, {})), 0);
}

TEST(PreprocessTest, O7_ColumnMedianByHand) {
  // Medians 10, 40 (of 20, 40, 90) and, without the invalid 200, the lower of 30 and 50. Target 60.
  const cv::Mat image = (cv::Mat_<unsigned char>(3, 3) << 10, 20, 200, 10, 40, 30, 30, 90, 50);
  const cv::Mat valid = (cv::Mat_<unsigned char>(3, 3) << 1, 1, 0, 1, 1, 1, 1, 1, 1);
  const GainConfig config{GainNormalisation::kColumnMedian, 129, 60};
  EXPECT_TRUE(same(normalise_gain({image, valid}, config), (cv::Mat_<unsigned char>(3, 3) << 60, 30, 0, 60, 60, 60, 180, 135, 100)));
}

TEST(PreprocessTest, O7_LocalMeanByHand) {
  // Window of 3: means 15 (10, 20), 20 (10, 20, 30), 25 (20, 30) with the fourth pixel invalid. Target 60.
  const cv::Mat image = (cv::Mat_<unsigned char>(1, 4) << 10, 20, 30, 255);
  const cv::Mat valid = (cv::Mat_<unsigned char>(1, 4) << 1, 1, 1, 0);
  const GainConfig config{GainNormalisation::kLocalMean, 3, 60};
  EXPECT_TRUE(same(normalise_gain({image, valid}, config), (cv::Mat_<unsigned char>(1, 4) << 40, 60, 72, 0)));
  EXPECT_THROW((void)normalise_gain({image, valid}, {GainNormalisation::kLocalMean, 4, 60}), InvalidArgument);
}

TEST(PreprocessTest, O7_AGainOfZeroIsNoMeasurement) {
  cv::Mat image = cv::Mat::zeros(5, 4, CV_8U);
  image.at<unsigned char>(2, 1) = 7;  // the median of its column is 0: taken as 1, not divided by
  for (const GainNormalisation kind : {GainNormalisation::kColumnMedian, GainNormalisation::kLocalMean}) {
    const cv::Mat result = normalise_gain({image, {}}, {kind, 3, 30});
    EXPECT_EQ(result.at<unsigned char>(2, 1), 210);
    EXPECT_EQ(cv::countNonZero(result), 1);
    EXPECT_EQ(cv::countNonZero(normalise_gain({image, cv::Mat::zeros(5, 4, CV_8U)}, {kind, 3, 30})), 0);
  }
}

TEST(PreprocessTest, O7_AMultiplicativeGainAcrossTrackGoesAway) {
  Rng rng(31);
  cv::Mat even(400, 200, CV_16U), uneven(400, 200, CV_16U);
  for (int r = 0; r < 400; ++r) {
    for (int c = 0; c < 200; ++c) {
      const double level = 4000 + 4000 * rng.uniform();
      even.at<unsigned short>(r, c) = static_cast<unsigned short>(level);
      uneven.at<unsigned short>(r, c) = static_cast<unsigned short>(level * (0.4 + 1.2 * c / 200));
    }
  }
  const GainConfig config{GainNormalisation::kColumnMedian, 129, 64};
  cv::Mat difference;
  cv::absdiff(normalise_gain({even, {}}, config), normalise_gain({uneven, {}}, config), difference);
  double largest = 0;
  cv::minMaxLoc(difference, nullptr, &largest);
  EXPECT_LE(largest, 1);  // both are rounded
  // The square of the local mean is larger than the gradient is even: 21 px are 6 % of the range.
  const cv::Mat local = normalise_gain({uneven, {}}, {GainNormalisation::kLocalMean, 21, 64});
  for (int first = 0; first < 200; first += 50) EXPECT_NEAR(cv::mean(local.colRange(first, first + 50))[0], 64, 2) << first;
}

TEST(PreprocessTest, O12_FiltersOfWholeImagesAreOpenCvs) {
  Rng rng(32);
  const cv::Mat image = noise<std::uint8_t>(rng, 40, 50, 1);
  const cv::Mat wide = noise<std::uint16_t>(rng, 40, 50, 200);
  cv::Mat expected;
  cv::medianBlur(image, expected, 5);
  EXPECT_TRUE(same(smooth_speckle({image, {}}, median(5)), expected));
  cv::medianBlur(wide, expected, 5);
  EXPECT_TRUE(same(smooth_speckle({wide, {}}, median(5)), expected));
  cv::GaussianBlur(wide, expected, {13, 13}, 2, 2);
  EXPECT_TRUE(same(smooth_speckle({wide, {}}, gaussian(2)), expected));
  cv::bilateralFilter(image, expected, 7, 60, 2);
  EXPECT_TRUE(same(smooth_speckle({image, {}}, bilateral(2, 60)), expected));
  EXPECT_TRUE(same(smooth_speckle({wide, {}}, {}), wide));
  EXPECT_THROW((void)smooth_speckle({wide, {}}, median(7)), InvalidArgument);
  EXPECT_THROW((void)smooth_speckle({image, {}}, median(4)), InvalidArgument);
}

TEST(PreprocessTest, O12_MedianOfTheValidPixelsByHand) {
  // Centre without its right column: 1, 2, 4, 5, 7, 9: the lower of 4 and 5. Top left: 1, 2, 4, 5: 2.
  const cv::Mat image = (cv::Mat_<unsigned char>(3, 3) << 1, 2, 200, 4, 5, 200, 7, 9, 200);
  const cv::Mat valid = (cv::Mat_<unsigned char>(3, 3) << 1, 1, 0, 1, 1, 0, 1, 1, 0);
  const cv::Mat filtered = smooth_speckle({image, valid}, median(3));
  EXPECT_EQ(filtered.at<unsigned char>(1, 1), 4);
  EXPECT_EQ(filtered.at<unsigned char>(0, 1), 2);
  EXPECT_EQ(cv::countNonZero(filtered.col(2)), 0);
}

TEST(PreprocessTest, O12_AnEvenPictureStaysEvenAroundInvalidPixels) {
  Rng rng(33);
  cv::Mat valid(300, 60, CV_8U);
  for (int i = 0; i < 300 * 60; ++i) valid.data[i] = rng.uniform() < 0.3 ? 0 : 1;
  for (const int type : {CV_8U, CV_16U}) {
    cv::Mat image(300, 60, type, cv::Scalar(90));
    image.setTo(250, valid == 0);
    for (const SpeckleFilterConfig& config : {median(5), gaussian(2), bilateral(2, 50)}) {
      const cv::Mat filtered = smooth_speckle({image, valid}, config);
      EXPECT_EQ(filtered.type(), type);
      EXPECT_EQ(cv::countNonZero((filtered == 90) != (valid != 0)), 0) << static_cast<int>(config.kind);
    }
  }
}

TEST(PreprocessTest, AMaskOfAllPixelsChangesNothingAwayFromTheBorders) {
  Rng rng(34);
  const cv::Mat image = noise<std::uint8_t>(rng, 600, 50, 1);
  const cv::Mat all(600, 50, CV_8U, cv::Scalar(1));
  const cv::Rect inside(7, 7, 36, 586);
  for (const SpeckleFilterConfig& config : {median(5), gaussian(2), bilateral(2, 50)}) {
    cv::Mat difference;
    cv::absdiff(smooth_speckle({image, {}}, config)(inside), smooth_speckle({image, all}, config)(inside), difference);
    double largest = 0;
    cv::minMaxLoc(difference, nullptr, &largest);
    EXPECT_LE(largest, 1) << static_cast<int>(config.kind);  // the Gaussian of whole 8-bit images is in fixed point
  }
}

TEST(PreprocessTest, WhatInvalidPixelsHoldHasNoSay) {
  Rng rng(35);
  cv::Mat valid = cv::Mat::zeros(90, 80, CV_8U);
  cv::circle(valid, {40, 45}, 33, 255, cv::FILLED);
  for (const bool wide : {false, true}) {
    const cv::Mat image = wide ? noise<std::uint16_t>(rng, 90, 80, 250) : noise<std::uint8_t>(rng, 90, 80, 1);
    cv::Mat disturbed = image.clone();
    disturbed.setTo(255, valid == 0);
    for (const SpeckleFilterConfig& config : {median(3), gaussian(1.5), bilateral(2, 50)})
      EXPECT_TRUE(same(smooth_speckle({image, valid}, config), smooth_speckle({disturbed, valid}, config)))
          << static_cast<int>(config.kind);
    for (const GainNormalisation kind : {GainNormalisation::kColumnMedian, GainNormalisation::kLocalMean})
      EXPECT_TRUE(same(normalise_gain({image, valid}, {kind, 31, 64}), normalise_gain({disturbed, valid}, {kind, 31, 64})));
    EXPECT_TRUE(same(power_law({image, valid}, {}), power_law({disturbed, valid}, {})));
  }
}

}  // namespace
}  // namespace ssjs
