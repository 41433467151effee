#include "ssjs/imaging/improved_otsu.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/threshold.hpp"

namespace ssjs {
namespace {

/// 35,500 pixels of 40, 100 spots of 3 x 3 pixels of 150, one square of 60 x 60 of 240.
cv::Mat spots_and_a_square() {
  cv::Mat image(200, 200, CV_8U, cv::Scalar(40));
  for (int i = 0; i < 100; ++i) image(cv::Rect(5 + 10 * (i % 20), 5 + 20 * (i / 20), 3, 3)) = 150;
  image(cv::Rect(70, 120, 60, 60)) = 240;
  return image;
}

ImprovedOtsuConfig config(int spot_px, int spot_limit) { return {spot_px, spot_limit, {}}; }

cv::Mat random_levels(Rng& rng, int rows, int columns) {
  cv::Mat image(rows, columns, CV_8U);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double echo = rng.uniform() < 0.1 ? 130 * rng.uniform() : 0;
      image.at<unsigned char>(r, c) = static_cast<unsigned char>(120 * rng.uniform() + echo);
    }
  }
  return image;
}

TEST(ImprovedOtsuTest, O10_TheSecondPassByHand) {
  // Whole range: split at 40: .8875 x .1125 x (222 - 40)^2 = 3307; at 150: .91 x .09 x (240 - 42.72)^2 = 3187. T = 40.
  // Above it two levels are left: T* is the lower one. Its edges are one ring a spot, and that of the square, of some 240 pixels.
  const std::optional<ImprovedOtsu> fired = improved_otsu({spots_and_a_square(), {}}, config(30, 99));
  ASSERT_TRUE(fired);
  EXPECT_EQ(fired->first_threshold, 40);
  EXPECT_EQ(fired->spots, 100);
  EXPECT_TRUE(fired->second_pass_fired);
  EXPECT_EQ(fired->threshold, 150);
  EXPECT_EQ(fired->spot_px, 30);
  EXPECT_EQ(fired->spot_limit, 99);
  EXPECT_DOUBLE_EQ(fired->canny_high, 40 / 255.0);  // O-8
}

TEST(ImprovedOtsuTest, O9_TheLimitItselfIsNotTooMany) {
  const std::optional<ImprovedOtsu> shut = improved_otsu({spots_and_a_square(), {}}, config(30, 100));
  ASSERT_TRUE(shut);
  EXPECT_EQ(shut->spots, 100);
  EXPECT_FALSE(shut->second_pass_fired);
  EXPECT_EQ(shut->threshold, 40);
  // A ring around 3 x 3 pixels has at least 8: none is smaller than 8. The square's ring has fewer than 1000.
  EXPECT_EQ(improved_otsu({spots_and_a_square(), {}}, config(8, 100))->spots, 0);
  EXPECT_EQ(improved_otsu({spots_and_a_square(), {}}, config(1000, 100))->spots, 101);
}

/// The paper's (10) with its (6) and (7): the smallest within-class variance over the levels from T + 1 on.
int brute_force(const Histogram& levels, int T) {
  double smallest = 1e300;
  int best = T;
  for (int candidate = T + 1; candidate < 255; ++candidate) {
    double within = 0, pixels = 0;
    bool two_classes = true;
    for (const auto& [first, last] : {std::pair{T + 1, candidate}, std::pair{candidate + 1, 255}}) {
      double n = 0, sum = 0;
      for (int i = first; i <= last; ++i) {
        n += static_cast<double>(levels[i]);
        sum += i * static_cast<double>(levels[i]);
      }
      two_classes = two_classes && n > 0;
      for (int i = first; i <= last && n > 0; ++i) within += static_cast<double>(levels[i]) * (i - sum / n) * (i - sum / n);
      pixels += n;
    }
    if (two_classes && within / pixels < smallest * (1 - 1e-12)) {
      smallest = within / pixels;
      best = candidate;
    }
  }
  return best;
}

TEST(ImprovedOtsuTest, O10_TheSecondThresholdIsThatOfAllThresholdsAboveTheFirst) {
  Rng rng(21);
  for (int round = 0; round < 40; ++round) {
    const cv::Mat image = random_levels(rng, 60, 70);
    const std::optional<ImprovedOtsu> found = improved_otsu({image, {}}, config(60, 0));
    ASSERT_TRUE(found);
    cv::Mat ignored;
    EXPECT_EQ(found->first_threshold, static_cast<int>(cv::threshold(image, ignored, 0, 255, cv::THRESH_OTSU)));
    ASSERT_TRUE(found->second_pass_fired);
    EXPECT_GT(found->threshold, found->first_threshold);
    EXPECT_EQ(found->threshold, brute_force(histogram({image, {}}), found->first_threshold));
  }
}

TEST(ImprovedOtsuTest, O10_OneLevelAboveTheFirstThresholdLeavesIt) {
  cv::Mat image = spots_and_a_square();
  image.setTo(240, image == 150);
  const std::optional<ImprovedOtsu> found = improved_otsu({image, {}}, config(30, 10));
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->second_pass_fired);
  EXPECT_EQ(found->first_threshold, 40);
  EXPECT_EQ(found->threshold, 40);
}

TEST(ImprovedOtsuTest, O11_AutomaticLimitsFollowTheNumberOfValidPixels) {
  // The paper's sizes: 0.0375 x 800 = 30, 0.0375 x 308.3 = 11.6, 0.0375 x 1337.7 = 50.2; it took 30, 15 and 40.
  EXPECT_EQ(automatic_spot_px(640000), 30);
  EXPECT_EQ(automatic_spot_px(95076), 12);
  EXPECT_EQ(automatic_spot_px(1789440), 50);
  EXPECT_EQ(automatic_spot_px(1), 10);
  EXPECT_EQ(automatic_spot_px(400000000), 60);
  EXPECT_NEAR(automatic_spot_limit(640000, 30), 304.76, 0.01);
  const std::optional<ImprovedOtsu> whole = improved_otsu({spots_and_a_square(), {}}, {});
  EXPECT_EQ(whole->spot_px, 10);  // 0.0375 x 200 = 7.5
  EXPECT_NEAR(whole->spot_limit, 40000 / 700.0, 1e-9);
  cv::Mat valid = cv::Mat::zeros(200, 200, CV_8U);
  valid.rowRange(0, 100) = 1;
  EXPECT_NEAR(improved_otsu({spots_and_a_square(), valid}, {})->spot_limit, 20000 / 700.0, 1e-9);
}

TEST(ImprovedOtsuTest, SixteenBitsOfTheSamePictureGiveTheSameSplit) {
  const cv::Mat image = spots_and_a_square();
  cv::Mat wide;
  image.convertTo(wide, CV_16U, 20, 1000);
  const std::optional<ImprovedOtsu> found = improved_otsu({wide, {}}, {30, 99, 0.2});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->spots, 100);
  EXPECT_EQ(found->first_threshold, 1000 + 20 * 40);
  EXPECT_EQ(found->threshold, 1000 + 20 * 150);
  // Unset: where the threshold lies between the darkest (40) and the brightest (240) pixel, as the contours are drawn.
  EXPECT_DOUBLE_EQ(improved_otsu({wide, {}}, config(30, 99))->canny_high, 0.0);
}

TEST(ImprovedOtsuTest, InvalidPixelsNeitherVoteNorCount) {
  Rng rng(22);
  const cv::Mat image = random_levels(rng, 80, 90);
  cv::Mat valid = cv::Mat::zeros(80, 90, CV_8U);
  cv::ellipse(valid, {45, 40}, {40, 30}, 20, 0, 360, 255, cv::FILLED);
  const std::optional<ImprovedOtsu> expected = improved_otsu({image, valid}, config(60, 5));
  ASSERT_TRUE(expected);
  for (const int level : {0, 200}) {
    cv::Mat disturbed = image.clone();
    disturbed.setTo(level, valid == 0);
    const std::optional<ImprovedOtsu> found = improved_otsu({disturbed, valid}, config(60, 5));
    EXPECT_EQ(found->first_threshold, expected->first_threshold);
    EXPECT_EQ(found->threshold, expected->threshold);
    EXPECT_EQ(found->spots, expected->spots);
  }
}

TEST(ImprovedOtsuTest, TilingAndTransposingMoveNoThreshold) {
  Rng rng(23);
  for (int round = 0; round < 10; ++round) {
    const cv::Mat image = random_levels(rng, 90, 110);
    for (const ImprovedOtsuConfig& gate : {config(30, 0), config(30, 1000000)}) {  // always open, always shut
      const int threshold = improved_otsu({image, {}}, gate)->threshold;
      EXPECT_EQ(improved_otsu({image.t(), {}}, gate)->threshold, threshold);
      EXPECT_EQ(improved_otsu({cv::repeat(image, 2, 3), {}}, gate)->threshold, threshold);
    }
  }
}

TEST(ImprovedOtsuTest, ImagesOfOneLevelHaveNoThreshold) {
  EXPECT_FALSE(improved_otsu({cv::Mat(9, 9, CV_8U, cv::Scalar(7)), {}}, {}));
  EXPECT_FALSE(improved_otsu({cv::Mat(1, 1, CV_16U, cv::Scalar(7)), {}}, {}));
  EXPECT_FALSE(improved_otsu({spots_and_a_square(), cv::Mat::zeros(200, 200, CV_8U)}, {}));
  EXPECT_THROW((void)improved_otsu({spots_and_a_square(), {}}, config(0, 5)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
