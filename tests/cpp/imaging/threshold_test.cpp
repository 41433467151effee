#include "ssjs/imaging/threshold.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using Method = std::optional<int> (*)(const Histogram&);

std::optional<int> otsu(const Histogram& histogram) { return otsu_threshold(histogram); }

constexpr Method kMethods[] = {otsu, iterative_threshold, maximum_entropy_threshold};

/// 8 pixels of 10, 8 of 12 and 9 of 200.
cv::Mat three_levels() {
  return (cv::Mat_<unsigned char>(5, 5) << 10, 12, 10, 12, 200,  //
          200, 10, 12, 10, 12,                                   //
          12, 200, 200, 12, 10,                                  //
          10, 200, 200, 200, 12,                                 //
          10, 12, 200, 200, 10);
}

Histogram of_levels(std::initializer_list<std::pair<int, int>> level_and_count) {
  Histogram histogram{std::vector<std::int64_t>(256)};
  for (const auto& [level, count] : level_and_count) histogram.counts[static_cast<std::size_t>(level)] = count;
  return histogram;
}

/// Each level of [first, last] occurs with the given probability.
Histogram random_histogram(Rng& rng, int levels, int first, int last, double probability) {
  Histogram histogram{std::vector<std::int64_t>(static_cast<std::size_t>(levels))};
  for (int i = first; i <= last; ++i) {
    if (rng.uniform() < probability) histogram.counts[static_cast<std::size_t>(i)] = 1 + static_cast<std::int64_t>(rng.below(60));
  }
  return histogram;
}

template <class Pixel>
cv::Mat image_of(const Histogram& histogram) {
  std::vector<Pixel> pixels;
  for (int level = 0; level < histogram.levels(); ++level)
    pixels.insert(pixels.end(), static_cast<std::size_t>(histogram[level]), static_cast<Pixel>(level));
  return cv::Mat_<Pixel>(pixels, true);
}

cv::Mat random_image(Rng& rng, int rows, int columns, int type) {
  cv::Mat image(rows, columns, type);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double bright = rng.uniform() < 0.2 ? 120 : 0;
      const double level = bright + 60 * rng.uniform() + 60 * rng.uniform();
      if (type == CV_8U) {
        image.at<unsigned char>(r, c) = static_cast<unsigned char>(level);
      } else {
        image.at<unsigned short>(r, c) = static_cast<unsigned short>(200 * level);
      }
    }
  }
  return image;
}

TEST(ThresholdTest, HistogramCountsValidPixelsOfBothDepths) {
  const Histogram all = histogram({three_levels(), {}});
  EXPECT_EQ(all.levels(), 256);
  EXPECT_EQ(all[10], 8);
  EXPECT_EQ(all[12], 8);
  EXPECT_EQ(all[200], 9);
  cv::Mat valid(5, 5, CV_8U, cv::Scalar(1));
  valid.row(0) = 0;
  EXPECT_EQ(histogram({three_levels(), valid})[10], 6);
  EXPECT_EQ(histogram({three_levels(), valid})[200], 8);
  cv::Mat wide;
  three_levels().convertTo(wide, CV_16U, 300);
  EXPECT_EQ(histogram({wide, {}}).levels(), 65536);
  EXPECT_EQ(histogram({wide, {}})[60000], 9);
  EXPECT_EQ(histogram({wide, valid})[60000], 8);
  EXPECT_EQ(occupied_levels(all), std::make_pair(10, 200));
  EXPECT_EQ(occupied_levels(all, 13), std::make_pair(200, 200));
  EXPECT_EQ(occupied_levels(all, 201), std::nullopt);
}

TEST(ThresholdTest, O2_OtsuOfThreeLevelsByHand) {
  // Split at 10: 8/25 x 17/25 x (1896/17 - 10)^2 = 2243. Split at 12: 16/25 x 9/25 x (200 - 11)^2 = 8230, the same up to 199.
  EXPECT_EQ(otsu_threshold(histogram({three_levels(), {}})), 12);
  // From 11 on, two levels are left.
  EXPECT_EQ(otsu_threshold(histogram({three_levels(), {}}), 11), 12);
  EXPECT_EQ(otsu_threshold(histogram({three_levels(), {}}), 13), std::nullopt);
}

TEST(ThresholdTest, O3_IterativeByHand) {
  // Starts at (10 + 200) / 2 = 105; means 11 and 200, midway 105.5: stays.
  EXPECT_EQ(iterative_threshold(histogram({three_levels(), {}})), 105);
  // Starts at 50; means 10 x 0 + 1 x 40 -> 40/11 and 100: 51.8. Stays at 51.
  EXPECT_EQ(iterative_threshold(of_levels({{0, 10}, {40, 1}, {100, 5}})), 51);
  // Starts at 50: {0 x 90} and {60 x 9, 100 x 1} = 64: 32. Stays at 32: 60 and 100 are the same class.
  EXPECT_EQ(iterative_threshold(of_levels({{0, 90}, {60, 9}, {100, 1}})), 32);
  // Starts at 50: {0 x 99, 40 x 2} = 0.8 and {52 x 9, 100 x 1} = 56.8: 28. Then 0 and {40 x 2, 52 x 9, 100 x 1} = 648/12 = 54: 27. Stays.
  EXPECT_EQ(iterative_threshold(of_levels({{0, 99}, {40, 2}, {52, 9}, {100, 1}})), 27);
}

TEST(ThresholdTest, O4_MaximumEntropyByHand) {
  // Split at 10: 0 + entropy(8/17, 9/17) = 0.6914. Split at 12: ln 2 + 0 = 0.6931.
  EXPECT_EQ(maximum_entropy_threshold(histogram({three_levels(), {}})), 12);
  // Four levels equally often: 1+3: ln 3 = 1.099; 2+2: 2 ln 2 = 1.386; 3+1: ln 3.
  EXPECT_EQ(maximum_entropy_threshold(of_levels({{0, 5}, {10, 5}, {20, 5}, {255, 5}})), 10);
}

TEST(ThresholdTest, O5_LocalMeanByHand) {
  cv::Mat image(5, 5, CV_8U, cv::Scalar(10));
  image.at<unsigned char>(2, 2) = 60;
  image.at<unsigned char>(0, 0) = 38;
  // Centre: 60 - (8 x 10 + 60) / 9 = 44.4. Corner: its window has four pixels, 38 - (38 + 30) / 4 = 21; with offset 21 it is not above.
  cv::Mat expected = cv::Mat::zeros(5, 5, CV_8U);
  expected.at<unsigned char>(2, 2) = 255;
  EXPECT_EQ(cv::countNonZero(local_foreground({image, {}}, {3, 21}) != expected), 0);
  expected.at<unsigned char>(0, 0) = 255;
  EXPECT_EQ(cv::countNonZero(local_foreground({image, {}}, {3, 20.9}) != expected), 0);
  // Without its two darker neighbours in the row and the column the corner is compared with (38 + 10) / 2 = 24.
  cv::Mat valid(5, 5, CV_8U, cv::Scalar(255));
  valid.at<unsigned char>(0, 1) = valid.at<unsigned char>(1, 0) = 0;
  expected.at<unsigned char>(0, 0) = 0;
  EXPECT_EQ(cv::countNonZero(local_foreground({image, valid}, {3, 20}) != expected), 0);
  EXPECT_THROW((void)local_foreground({image, {}}, {4, 20}), InvalidArgument);
  EXPECT_THROW((void)local_foreground({image, {}}, {1, 20}), InvalidArgument);
}

TEST(ThresholdTest, O5_LocalMeanOfAWindowLargerThanTheImageIsThatOfTheImage) {
  Rng rng(3);
  const cv::Mat image = random_image(rng, 7, 9, CV_16U);
  const double mean = cv::mean(image)[0];
  EXPECT_EQ(cv::countNonZero(local_foreground({image, {}}, {99, 100}) != (image > mean + 100)), 0);
}

TEST(ThresholdTest, O5_LocalMeanAwayFromTheBordersIsThatOfASum) {
  Rng rng(4);
  const cv::Mat image = random_image(rng, 60, 80, CV_8U);
  const cv::Mat mask = local_foreground({image, {}}, {11, 20});
  for (int r = 5; r < 55; ++r) {
    for (int c = 5; c < 75; ++c) {
      const double above = image.at<unsigned char>(r, c) - cv::mean(image(cv::Rect(c - 5, r - 5, 11, 11)))[0];
      if (std::abs(above - 20) > 1e-9) {
        EXPECT_EQ(mask.at<unsigned char>(r, c) != 0, above > 20) << r << " " << c;
      }
    }
  }
}

TEST(ThresholdTest, O2_OtsuIsThatOfOpenCv) {
  Rng rng(11);
  for (int round = 0; round < 1000; ++round) {
    const Histogram histogram = random_histogram(rng, 256, 0, 255, 1.0);
    cv::Mat ignored;
    const double expected = cv::threshold(image_of<unsigned char>(histogram), ignored, 0, 255, cv::THRESH_OTSU);
    ASSERT_EQ(otsu_threshold(histogram), static_cast<int>(expected)) << "round " << round;
  }
}

TEST(ThresholdTest, O2_OtsuOfFewLevelsSplitsAsOpenCvDoes) {
  // Between two occupied levels all thresholds are equally good, and rounding decides which of them OpenCV takes: the split is compared.
  Rng rng(12);
  for (int round = 0; round < 1000; ++round) {
    Histogram histogram = random_histogram(rng, 256, 0, 255, 0.05);
    histogram.counts[rng.below(100)] = 7;
    histogram.counts[100 + rng.below(100)] = 5;
    const cv::Mat image = image_of<unsigned char>(histogram);
    cv::Mat expected;
    const double threshold = cv::threshold(image, expected, 0, 255, cv::THRESH_OTSU);
    const std::optional<int> ours = otsu_threshold(histogram);
    ASSERT_TRUE(ours);
    ASSERT_EQ(cv::countNonZero(foreground({image, {}}, *ours) != expected), 0) << "round " << round;
    ASSERT_LE(*ours, threshold);
    ASSERT_GT(histogram[*ours], 0) << "the lowest of the equal ones is an occupied level";
  }
}

TEST(ThresholdTest, O2_OtsuOfSixteenBitsIsThatOfOpenCv) {
  Rng rng(13);
  for (int round = 0; round < 30; ++round) {
    const Histogram histogram = random_histogram(rng, 65536, 3000, 9000, 1.0);
    cv::Mat ignored;
    const double expected = cv::threshold(image_of<unsigned short>(histogram), ignored, 0, 65535, cv::THRESH_OTSU);
    ASSERT_EQ(otsu_threshold(histogram), static_cast<int>(expected)) << "round " << round;
  }
}

TEST(ThresholdTest, O3_IterativeIsAFixedPoint) {
  Rng rng(14);
  for (int round = 0; round < 500; ++round) {
    const Histogram histogram = random_histogram(rng, 256, 0, 255, 0.3);
    const std::optional<int> threshold = iterative_threshold(histogram);
    ASSERT_TRUE(threshold);
    std::vector<double> low, high;
    for (int level = 0; level < 256; ++level) {
      auto& pixels = level <= *threshold ? low : high;
      pixels.insert(pixels.end(), static_cast<std::size_t>(histogram[level]), level);
    }
    ASSERT_FALSE(low.empty() || high.empty());
    const double midway = (cv::mean(low)[0] + cv::mean(high)[0]) / 2;
    EXPECT_TRUE(midway >= *threshold - 1e-9 && midway < *threshold + 1 + 1e-9) << *threshold << " " << midway;
  }
}

double entropy(const Histogram& histogram, int first, int last) {
  double pixels = 0, sum = 0;
  for (int level = first; level <= last; ++level) pixels += static_cast<double>(histogram[level]);
  for (int level = first; level <= last; ++level) {
    const double p = static_cast<double>(histogram[level]) / pixels;
    if (p > 0) sum -= p * std::log(p);
  }
  return sum;
}

TEST(ThresholdTest, O4_MaximumEntropyIsThatOfAllThresholds) {
  Rng rng(15);
  for (int round = 0; round < 200; ++round) {
    const Histogram histogram = random_histogram(rng, 256, 5, 240, round % 2 == 0 ? 1.0 : 0.2);
    const auto [lowest, highest] = *occupied_levels(histogram);
    double largest = 0;
    for (int level = lowest; level < highest; ++level)
      largest = std::max(largest, entropy(histogram, lowest, level) + entropy(histogram, level + 1, highest));
    const std::optional<int> threshold = maximum_entropy_threshold(histogram);
    ASSERT_TRUE(threshold);
    EXPECT_NEAR(entropy(histogram, lowest, *threshold) + entropy(histogram, *threshold + 1, highest), largest, 1e-12);
  }
}

TEST(ThresholdTest, NeitherTransposingNorTilingMovesAThreshold) {
  Rng rng(16);
  for (int type : {CV_8U, CV_16U}) {
    for (int round = 0; round < 20; ++round) {
      const cv::Mat image = random_image(rng, 20 + round, 31, type);
      const cv::Mat tiled = cv::repeat(image, 3, 5);
      for (const Method method : kMethods) {
        const std::optional<int> threshold = method(histogram({image, {}}));
        EXPECT_TRUE(threshold);
        EXPECT_EQ(method(histogram({image.t(), {}})), threshold);
        EXPECT_EQ(method(histogram({tiled, {}})), threshold);
      }
    }
  }
}

TEST(ThresholdTest, InvalidPixelsNeverVote) {
  Rng rng(17);
  for (int type : {CV_8U, CV_16U}) {
    const cv::Mat image = random_image(rng, 40, 50, type);
    cv::Mat valid(40, 50, CV_8U);
    for (int i = 0; i < 2000; ++i) valid.data[i] = rng.uniform() < 0.5 ? 0 : static_cast<unsigned char>(1 + rng.below(255));
    cv::Mat disturbed = image.clone();
    disturbed.setTo(255, valid == 0);
    for (const Method method : kMethods) EXPECT_EQ(method(histogram({image, valid})), method(histogram({disturbed, valid})));
    const LocalThresholdConfig config{15, 20};
    EXPECT_EQ(cv::countNonZero(local_foreground({image, valid}, config) != local_foreground({disturbed, valid}, config)), 0);
    EXPECT_EQ(cv::countNonZero(local_foreground({disturbed, valid}, config) & (valid == 0)), 0);
    EXPECT_EQ(cv::countNonZero(foreground({disturbed, valid}, 100) & (valid == 0)), 0);
    EXPECT_EQ(cv::countNonZero(foreground({image, valid}, 100) != ((image > 100) & (valid > 0))), 0);
  }
}

TEST(ThresholdTest, ImagesOfOneLevelHaveNoThreshold) {
  const cv::Mat flat(6, 7, CV_8U, cv::Scalar(90));
  const cv::Mat flat_wide(6, 7, CV_16U, cv::Scalar(900));
  const cv::Mat dot(1, 1, CV_8U, cv::Scalar(255));
  const cv::Mat none = cv::Mat::zeros(5, 5, CV_8U);
  cv::Mat one = none.clone();
  one.at<unsigned char>(2, 2) = 1;
  for (const Method method : kMethods) {
    EXPECT_EQ(method(histogram({flat, {}})), std::nullopt);
    EXPECT_EQ(method(histogram({flat_wide, {}})), std::nullopt);
    EXPECT_EQ(method(histogram({dot, {}})), std::nullopt);
    EXPECT_EQ(method(histogram({three_levels(), none})), std::nullopt);
    EXPECT_EQ(method(histogram({three_levels(), one})), std::nullopt);
  }
  EXPECT_EQ(cv::countNonZero(local_foreground({dot, {}}, {3, 0})), 0);
  EXPECT_THROW((void)histogram({}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
