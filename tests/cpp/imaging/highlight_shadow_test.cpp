#include "ssjs/imaging/highlight_shadow.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "imaging/drawn_mask.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/imaging/shadow_height.hpp"

namespace ssjs {
namespace {

const cv::Rect kTarget(80, 40, 10, 20);
const cv::Rect kShadow(90, 40, 30, 20);

/// Seabed of grey 90, a target of 230 and its shadow of 5, on starboard.
cv::Mat scene() {
  cv::Mat image(100, 200, CV_8U, cv::Scalar(90));
  image(kTarget) = 230;
  image(kShadow) = 5;
  return image;
}

/// Levels as they are drawn, without the median.
HighlightShadowConfig plain() {
  HighlightShadowConfig config;
  config.median_px = 1;
  return config;
}

cv::Mat mirrored(const cv::Mat& image) {
  cv::Mat out;
  cv::flip(image, out, 1);
  return out;
}

TEST(HighlightShadowTest, R12_R13_DrawnTargetWithKnownAreaAndShadow) {
  const HighlightShadows found = highlight_shadow({scene(), {}}, 0, plain());
  ASSERT_TRUE(found.thresholds);
  EXPECT_EQ(found.thresholds->shadow_below, 90);     // 3 % are darker, the level of the 5 % quantile is the seabed's
  EXPECT_EQ(found.thresholds->highlight_above, 90);  // 1 % is brighter
  ASSERT_EQ(found.objects.size(), 1u);
  const ShadowedObject& target = found.objects[0];
  EXPECT_EQ(target.side, SonarSide::kStarboard);
  EXPECT_EQ(target.highlight_area_px, 200);
  EXPECT_EQ(target.shadow_area_px, 600);
  EXPECT_EQ(target.centroid_px, cv::Point2d(84.5, 49.5));
  EXPECT_EQ(target.highlight_box, kTarget);
  EXPECT_EQ(target.shadow_box, kShadow);
  EXPECT_EQ(target.contact_px, 24);  // 20 rows and 2 of magnification on either side
  EXPECT_EQ(target.shadow_start_px, 90);
  EXPECT_EQ(target.shadow_tip_px, 120);
  EXPECT_FALSE(target.shadow_is_cut);
  EXPECT_EQ(cv::countNonZero(found.highlights), 14 * 24);
  EXPECT_EQ(cv::countNonZero(found.shadows), 34 * 24);
  // 0.1 m a pixel, the sonar 4 m up: 4 x 3 / 12
  EXPECT_NEAR(height_from_shadow_m(4.0, 0.1 * target.shadow_start_px, 0.1 * target.shadow_tip_px, ShadowRanges::kGround), 1.0, 1e-12);
}

TEST(HighlightShadowTest, PortIsTheMirrorImage) {
  const HighlightShadows found = highlight_shadow({mirrored(scene()), {}}, 200, plain());
  ASSERT_EQ(found.objects.size(), 1u);
  const ShadowedObject& target = found.objects[0];
  EXPECT_EQ(target.side, SonarSide::kPort);
  EXPECT_EQ(target.centroid_px, cv::Point2d(114.5, 49.5));  // 199 - 84.5
  EXPECT_EQ(target.highlight_box, cv::Rect(110, 40, 10, 20));
  EXPECT_EQ(target.shadow_box, cv::Rect(80, 40, 30, 20));
  EXPECT_EQ(target.shadow_start_px, 90);
  EXPECT_EQ(target.shadow_tip_px, 120);
  const HighlightShadows starboard = highlight_shadow({scene(), {}}, 0, plain());
  EXPECT_EQ(text(mirrored(found.highlights)), text(starboard.highlights));
  EXPECT_EQ(text(mirrored(found.shadows)), text(starboard.shadows));
}

TEST(HighlightShadowTest, RangesCountFromTheNadirOnBothSides) {
  cv::Mat both;
  cv::hconcat(mirrored(scene()), scene(), both);
  const HighlightShadows found = highlight_shadow({both, {}}, 200, plain());
  ASSERT_EQ(found.objects.size(), 2u);
  EXPECT_EQ(found.objects[0].side, SonarSide::kPort);
  EXPECT_EQ(found.objects[0].centroid_px.x, 114.5);
  EXPECT_EQ(found.objects[1].side, SonarSide::kStarboard);
  EXPECT_EQ(found.objects[1].centroid_px.x, 284.5);
  for (const ShadowedObject& object : found.objects) EXPECT_EQ(object.shadow_tip_px, 120);
}

TEST(HighlightShadowTest, R12_AShadowBeforeItsHighlightIsAPit) {
  EXPECT_TRUE(highlight_shadow({scene(), {}}, 200, plain()).objects.empty());  // the sonar on the other side
  EXPECT_TRUE(highlight_shadow({mirrored(scene()), {}}, 0, plain()).objects.empty());
}

TEST(HighlightShadowTest, R12_HighlightsAndShadowsAloneAreNoObjects) {
  cv::Mat apart(100, 200, CV_8U, cv::Scalar(90));
  apart(cv::Rect(80, 40, 10, 20)) = 230;
  apart(cv::Rect(95, 40, 30, 20)) = 5;  // 5 clear columns; 2 dilations each bridge 4
  EXPECT_TRUE(highlight_shadow({apart, {}}, 0, plain()).objects.empty());
  apart(cv::Rect(94, 40, 1, 20)) = 5;
  EXPECT_EQ(highlight_shadow({apart, {}}, 0, plain()).objects.size(), 1u);
  cv::Mat beside(100, 200, CV_8U, cv::Scalar(90));
  beside(cv::Rect(80, 10, 10, 20)) = 230;
  beside(cv::Rect(90, 40, 30, 20)) = 5;
  EXPECT_TRUE(highlight_shadow({beside, {}}, 0, plain()).objects.empty());
}

TEST(HighlightShadowTest, R12_ALightInTheMiddleOfTheDarkCastsNoShadow) {
  cv::Mat image(100, 200, CV_8U, cv::Scalar(90));
  image(cv::Rect(70, 30, 50, 40)) = 5;
  image(cv::Rect(90, 40, 3, 20)) = 230;  // the magnified dark closes over 3 columns
  HighlightShadowConfig config = plain();
  config.shadow_quantile = 0.15;  // the dark is 9.7 %
  const HighlightShadows found = highlight_shadow({image, {}}, 0, config);
  EXPECT_GT(cv::countNonZero(found.highlights), 0);
  EXPECT_GT(cv::countNonZero(found.shadows), 0);
  EXPECT_TRUE(found.objects.empty());
}

TEST(HighlightShadowTest, R13_TheLongestRowCounts) {
  cv::Mat image = scene();
  image(cv::Rect(120, 48, 5, 1)) = 5;
  const ShadowedObject target = highlight_shadow({image, {}}, 0, plain()).objects.at(0);
  EXPECT_EQ(target.shadow_tip_px, 125);
  EXPECT_EQ(target.shadow_area_px, 605);
}

TEST(HighlightShadowTest, AShadowAtTheEndOfTheSwathIsCut) {
  cv::Mat image(100, 200, CV_8U, cv::Scalar(90));
  image(cv::Rect(170, 40, 10, 20)) = 230;
  image(cv::Rect(180, 40, 20, 20)) = 5;
  EXPECT_TRUE(highlight_shadow({image, {}}, 0, plain()).objects.at(0).shadow_is_cut);

  cv::Mat valid(100, 200, CV_8U, cv::Scalar(1));
  valid.colRange(110, 200) = 0;
  const HighlightShadows found = highlight_shadow({scene(), valid}, 0, plain());
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_TRUE(found.objects[0].shadow_is_cut);
  EXPECT_EQ(found.objects[0].shadow_tip_px, 110);
}

TEST(HighlightShadowTest, InvalidPixelsCastNoShadow) {
  cv::Mat image(100, 200, CV_8U, cv::Scalar(90));
  image(kTarget) = 230;
  image.colRange(90, 200) = 0;
  cv::Mat valid(100, 200, CV_8U, cv::Scalar(255));
  valid.colRange(90, 200) = 0;
  for (const int median_px : {1, 5}) {
    HighlightShadowConfig config = plain();
    config.median_px = median_px;
    config.highlight_quantile = 0.95;  // the target is 2.2 % of the valid pixels
    const HighlightShadows found = highlight_shadow({image, valid}, 0, config);
    EXPECT_TRUE(found.objects.empty());
    EXPECT_EQ(cv::countNonZero(found.shadows), 0);
    EXPECT_GT(cv::countNonZero(found.highlights), 0);
  }
  EXPECT_EQ(highlight_shadow({image, {}}, 0,
                             [] {
                               HighlightShadowConfig grey = plain();
                               grey.levels = EchoLevels::kGrey;
                               return grey;
                             }())
                .objects.size(),
            1u);
}

TEST(HighlightShadowTest, R11_TheThreeWaysToLevels) {
  HighlightShadowConfig config = plain();
  config.levels = EchoLevels::kOtsu;
  const HighlightShadows otsu = highlight_shadow({scene(), {}}, 0, config);
  ASSERT_TRUE(otsu.thresholds);
  EXPECT_EQ(otsu.thresholds->shadow_below, 6);
  EXPECT_EQ(otsu.thresholds->highlight_above, 90);
  ASSERT_EQ(otsu.objects.size(), 1u);
  EXPECT_EQ(otsu.objects[0].highlight_area_px, 200);

  config.levels = EchoLevels::kGrey;
  config.shadow_grey = 5;  // darker than 5: nothing
  EXPECT_TRUE(highlight_shadow({scene(), {}}, 0, config).objects.empty());
  config.shadow_grey = 6;
  config.highlight_grey = 230;
  EXPECT_TRUE(highlight_shadow({scene(), {}}, 0, config).objects.empty());
  config.highlight_grey = 229;
  EXPECT_EQ(highlight_shadow({scene(), {}}, 0, config).objects.size(), 1u);
}

TEST(HighlightShadowTest, SixteenBitsGiveWhatEightGive) {
  cv::Mat wide;
  scene().convertTo(wide, CV_16U, 200, 77);
  const HighlightShadows found = highlight_shadow({wide, {}}, 0, plain());
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_EQ(found.objects[0].centroid_px, cv::Point2d(84.5, 49.5));
}

TEST(HighlightShadowTest, TargetsInSpeckleAreFoundTwiceTheSame) {
  // Rayleigh-distributed amplitudes of mean 90 (seabed), 230 and 12: sigma = mean / sqrt(pi / 2).
  Rng rng(41);
  const cv::Mat means = scene();
  cv::Mat image(means.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double mean = means.at<unsigned char>(y, x) == 5 ? 12.0 : means.at<unsigned char>(y, x);
      const double amplitude = mean / std::sqrt(1.5707963) * std::hypot(rng.normal(), rng.normal());
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(amplitude);
    }
  }
  HighlightShadowConfig config;
  config.shadow_quantile = 0.04;
  config.highlight_quantile = 0.985;
  const HighlightShadows found = highlight_shadow({image, {}}, 0, config);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_NEAR(found.objects[0].centroid_px.x, 84.5, 1.5);
  EXPECT_NEAR(found.objects[0].centroid_px.y, 49.5, 1.5);
  EXPECT_NEAR(found.objects[0].shadow_start_px, 90, 3);  // half the median's window
  EXPECT_NEAR(found.objects[0].shadow_tip_px, 120, 3);
  const HighlightShadows again = highlight_shadow({image, {}}, 0, config);
  EXPECT_EQ(again.objects[0].centroid_px, found.objects[0].centroid_px);
  EXPECT_EQ(text(again.highlights), text(found.highlights));
  EXPECT_EQ(text(again.shadows), text(found.shadows));
}

TEST(HighlightShadowTest, NothingToSee) {
  EXPECT_TRUE(highlight_shadow({cv::Mat(5, 5, CV_8U, cv::Scalar(90)), {}}, 2, {}).objects.empty());
  EXPECT_TRUE(highlight_shadow({cv::Mat(1, 1, CV_8U, cv::Scalar(90)), {}}, 1, {}).objects.empty());
  HighlightShadowConfig otsu;
  otsu.levels = EchoLevels::kOtsu;
  EXPECT_FALSE(highlight_shadow({cv::Mat(5, 5, CV_8U, cv::Scalar(90)), {}}, 2, otsu).thresholds);
  EXPECT_FALSE(highlight_shadow({scene(), cv::Mat::zeros(100, 200, CV_8U)}, 0, {}).thresholds);
}

TEST(HighlightShadowTest, ContradictionsAreRefused) {
  const auto run = [](int nadir_column, const HighlightShadowConfig& config) {
    static_cast<void>(highlight_shadow({scene(), {}}, nadir_column, config));
  };
  EXPECT_THROW(run(-1, {}), InvalidArgument);
  EXPECT_THROW(run(201, {}), InvalidArgument);
  HighlightShadowConfig config;
  config.median_px = 4;
  EXPECT_THROW(run(0, config), InvalidArgument);
  config = {};
  config.shadow_grey = 201;
  EXPECT_THROW(run(0, config), InvalidArgument);
  config = {};
  config.shadow_quantile = 0.99;
  EXPECT_THROW(run(0, config), InvalidArgument);
  config = {};
  config.smallest_contact_px = 0;
  EXPECT_THROW(run(0, config), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
