#include "ssjs/cascade/haar_feature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <set>
#include <tuple>

#include "cascade/speckle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const cv::Size kWindow(24, 24);

TEST(HaarFeatureTest, C5_ClassicSetsHaveTheKnownSizes) {
  // n cells of width d in a row have side + 1 - n d places.
  const auto places = [](int cells, int side) {
    int sum = 0;
    for (int d = 1; cells * d <= side; ++d) sum += side + 1 - cells * d;
    return sum;
  };
  const int basic = 2 * places(2, 24) * places(1, 24) + 2 * places(3, 24) * places(1, 24) + places(2, 24) * places(2, 24);
  EXPECT_EQ(basic, 162336);
  EXPECT_EQ(enumerate_features(FeatureSet::kBasic, kWindow).size(), 162336U);
  const int core = basic + 2 * places(4, 24) * places(1, 24) + places(3, 24) * places(3, 24);
  EXPECT_EQ(enumerate_features(FeatureSet::kCore, kWindow).size(), static_cast<std::size_t>(core));
  EXPECT_GT(enumerate_features(FeatureSet::kAll, kWindow).size(), static_cast<std::size_t>(core));
}

TEST(HaarFeatureTest, EveryFeatureLiesInTheWindowAndIgnoresEqualLight) {
  Rng rng(1);
  const cv::Size window(11, 9);
  const cv::Mat flat(window, CV_8U, cv::Scalar(93));
  const IntegralImage integral(flat, IntegralImage::Diagonal::kWith);
  for (const FeatureSet set : {FeatureSet::kBasic, FeatureSet::kCore, FeatureSet::kAll, FeatureSet::kSideScan, FeatureSet::kSideScanBasic})
    for (const HaarFeature& feature : enumerate_features(set, window)) {
      EXPECT_NO_THROW(check_feature(feature, window));
      EXPECT_EQ(feature_value(feature, integral, {0, 0}, 1), 0.0F) << to_string(set);
    }
}

TEST(HaarFeatureTest, NoFeatureOccursTwiceWithinTheSideScanFamily) {
  std::set<std::vector<float>> seen;
  const auto features = enumerate_features(FeatureSet::kSideScan, {12, 8});
  for (const HaarFeature& feature : features) {
    std::vector<float> key;
    for (const WeightedRect& part : feature.rects) {
      for (const int number : {part.rect.x, part.rect.y, part.rect.width, part.rect.height}) key.push_back(static_cast<float>(number));
      key.push_back(part.weight);
    }
    EXPECT_TRUE(seen.insert(key).second);
  }
  EXPECT_EQ(seen.size(), features.size());
}

TEST(HaarFeatureTest, C6_EightDarkToOneBrightByHand) {
  // Columns 0..7 dark (10), column 8 bright (90), 4 rows: -sum of all + 9 x bright = -(8 x 40 + 360) + 9 x 360 = 2560 = 8 x (360 - 40).
  cv::Mat image(4, 9, CV_8U, cv::Scalar(10));
  image.col(8).setTo(90);
  const IntegralImage integral(image);
  const HaarFeature expected{{{{{0, 0, 9, 4}, -1}, {{8, 0, 1, 4}, 9}, {}}}, false};
  const auto features = enumerate_features(FeatureSet::kSideScan, image.size());
  EXPECT_EQ(std::count(features.begin(), features.end(), expected), 1);
  EXPECT_EQ(feature_value(expected, integral, {0, 0}, 1), 2560.0F);
}

TEST(HaarFeatureTest, C4_NormalisationIsTheReciprocalOfAreaTimesDeviation) {
  Rng rng(2);
  const cv::Mat image = speckle({40, 30}, rng);
  const auto norm = normalisation(IntegralImage(image), {5, 3}, kWindow);
  ASSERT_TRUE(norm);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image(cv::Rect(6, 4, 22, 22)), mean, deviation);
  EXPECT_NEAR(*norm * 22 * 22 * deviation[0], 1, 1e-6);
}

TEST(HaarFeatureTest, C4_FlatWindowsHaveNoNormalisation) {
  EXPECT_FALSE(normalisation(IntegralImage(cv::Mat(24, 24, CV_8U, cv::Scalar(50))), {0, 0}, kWindow));
  // Half 40, half 60 deviates by exactly 10 grey levels: not above the bound. Half 40, half 62 deviates by 11: above.
  for (const int brighter : {60, 62}) {
    cv::Mat halves(24, 24, CV_8U, cv::Scalar(40));
    halves.colRange(12, 24).setTo(brighter);
    EXPECT_EQ(normalisation(IntegralImage(halves), {0, 0}, kWindow).has_value(), brighter == 62);
  }
}

TEST(HaarFeatureTest, MirroredFeatureOnAMirroredWindowGivesTheSame) {
  Rng rng(6);
  const cv::Size window(9, 10);
  const cv::Mat image = speckle(window, rng);
  cv::Mat flipped;
  cv::flip(image, flipped, 1);
  const IntegralImage integral(image, IntegralImage::Diagonal::kWith);
  const IntegralImage integral_flipped(flipped, IntegralImage::Diagonal::kWith);
  int tilted = 0;
  for (const HaarFeature& feature : enumerate_features(FeatureSet::kAll, window)) {
    const auto mirror = mirrored(feature, window);
    if (!mirror) {
      EXPECT_TRUE(feature.tilted);
      continue;
    }
    tilted += feature.tilted ? 1 : 0;
    EXPECT_EQ(feature_value(*mirror, integral_flipped, {0, 0}, 1), feature_value(feature, integral, {0, 0}, 1));
  }
  EXPECT_GT(tilted, 100);
}

TEST(HaarFeatureTest, RectanglesOutsideTheWindowAreRefused) {
  const auto with = [](cv::Rect rect, bool tilted) { return HaarFeature{{{{{0, 0, 2, 2}, -1}, {rect, 2}, {}}}, tilted}; };
  EXPECT_THROW(check_feature(with({20, 0, 5, 2}, false), kWindow), InvalidArgument);
  EXPECT_THROW(check_feature(with({-1, 0, 5, 2}, false), kWindow), InvalidArgument);
  EXPECT_THROW(check_feature(with({0, 0, 0, 2}, false), kWindow), InvalidArgument);
  EXPECT_THROW(check_feature(with({2000000000, 0, 2000000000, 2}, false), kWindow), InvalidArgument);
  EXPECT_THROW(check_feature(with({3, 0, 2, 4}, true), kWindow), InvalidArgument);  // its left corner would be at -1
  EXPECT_THROW(check_feature({}, kWindow), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
