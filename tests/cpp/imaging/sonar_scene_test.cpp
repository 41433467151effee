#include "ssjs/imaging/sonar_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "imaging/scene_outcome.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr std::uint64_t kSeeds = 10;

/// A scene of the paper's three with the settings of its preset.
struct Case {
  std::string name;
  SpottedSceneConfig scene;
  SegmentationConfig segmentation;
};

std::vector<Case> cases() {
  return {{"ship", ship_scene(), segmentation_preset(SegmentationPreset::kSideScanHigh)},
          {"branch", branch_scene(), segmentation_preset(SegmentationPreset::kSideScanLow)},
          {"body", body_scene(), segmentation_preset(SegmentationPreset::kForwardLooking)}};
}

/// A seabed as bright as the ship's: all with the ship's gradient of a strong edge. That of the others' presets sees the speckle.
std::vector<Case> even_seabed() {
  std::vector<Case> all = cases();
  for (Case& one : all) one.segmentation.improved_otsu.canny_high = 0.33;
  return all;
}

/// As dark as in the paper's pictures, with its own gradients.
std::vector<Case> dark_seabed() {
  std::vector<Case> all = cases();
  for (Case& one : all) one.scene.background_level = 20;
  return all;
}

/// So much speckle that the entropy's threshold is better than Otsu's, and that the speckle itself is counted as spots.
std::vector<Case> loud_seabed() {
  std::vector<Case> all = even_seabed();
  for (Case& one : all) {
    one.scene.background_level = 70;
    one.scene.looks = 4;
  }
  return all;
}

/// The paper's claim for one scene: the second threshold is above the first, and keeps fewer spots than the entropy's, and the object.
void expect_better_than_entropy(const Case& one, std::uint64_t seed) {
  SCOPED_TRACE(one.name + ", seed " + std::to_string(seed));
  const SonarScene scene = simulate_spotted_scene(one.scene, Rng(seed));
  const SceneOutcome improved = outcome(scene, one.segmentation);
  const SceneOutcome entropy = outcome(scene, with_method(one.segmentation, ThresholdMethod::kMaximumEntropy));
  ASSERT_TRUE(improved.result.improved_otsu);
  const ImprovedOtsu& found = *improved.result.improved_otsu;
  EXPECT_GT(static_cast<double>(found.spots), found.spot_limit);
  EXPECT_TRUE(found.second_pass_fired);
  EXPECT_GT(found.threshold, found.first_threshold);
  EXPECT_GT(found.threshold, *entropy.result.threshold);
  EXPECT_LT(improved.false_positive_rate(), entropy.false_positive_rate());
  EXPECT_GT(improved.precision(), entropy.precision());
  EXPECT_EQ(improved.pieces(), 1U);
  EXPECT_LE(improved.centroid_error_px(), 2);
}

void expect_shut_without_spots(Case one, std::uint64_t seed) {
  SCOPED_TRACE(one.name + " without spots, seed " + std::to_string(seed));
  one.scene.spots = 0;
  const SceneOutcome plain = outcome(simulate_spotted_scene(one.scene, Rng(seed)), one.segmentation);
  ASSERT_TRUE(plain.result.improved_otsu);
  EXPECT_LE(static_cast<double>(plain.result.improved_otsu->spots), plain.result.improved_otsu->spot_limit);
  EXPECT_FALSE(plain.result.improved_otsu->second_pass_fired);
  EXPECT_EQ(plain.result.improved_otsu->threshold, plain.result.improved_otsu->first_threshold);
  EXPECT_LE(plain.centroid_error_px(), 2);
}

TEST(SonarSceneTest, O14_TheClaimHoldsOnAnEvenSeabed) {
  for (const Case& one : even_seabed()) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      expect_better_than_entropy(one, seed);
      expect_shut_without_spots(one, seed);
    }
  }
}

TEST(SonarSceneTest, O14_TheClaimHoldsUnderLoudSpeckle) {
  for (const Case& one : loud_seabed()) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) expect_better_than_entropy(one, seed);
  }
}

TEST(SonarSceneTest, O14_TheClaimHoldsOnADarkSeabedLong) {
  for (const Case& one : dark_seabed()) {
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      expect_better_than_entropy(one, seed);
      expect_shut_without_spots(one, seed);
    }
  }
}

TEST(SonarSceneTest, O15_UnevenGainIsOvercomeAtLowContrast) {
  SegmentationConfig config = segmentation_preset(SegmentationPreset::kAutomatic);
  config.filter.kind = SpeckleFilter::kGaussian;
  config.filter.sigma_px = 3;
  for (const auto& [kind, window_px] : {std::pair{GainNormalisation::kColumnMedian, 129}, std::pair{GainNormalisation::kLocalMean, 257}}) {
    config.gain.kind = kind;
    config.gain.window_px = window_px;
    for (const double contrast : {2.0, 1.5}) {
      UnevenGainSceneConfig uneven;
      uneven.contrast = contrast;
      double iou = 0;
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const SonarScene scene = simulate_uneven_gain_scene(uneven, Rng(seed));
        iou += largest_region_iou(scene, segment(scene.image, config)) / 3;
      }
      EXPECT_GE(iou, 0.90) << "contrast " << contrast << ", window " << window_px;
    }
  }
}

TEST(SonarSceneTest, O15_WithoutGainNormalisationTheBrightSideIsTheObject) {
  UnevenGainSceneConfig uneven;
  uneven.contrast = 1.5;
  const SonarScene scene = simulate_uneven_gain_scene(uneven, Rng(0));
  EXPECT_LT(largest_region_iou(scene, segment(scene.image, segmentation_preset(SegmentationPreset::kAutomatic))), 0.1);
}

TEST(SonarSceneTest, O13_SpeckleHasTheMeanAndVarianceOfItsLooks) {
  // 640,000 pixels: the mean of the seabed is known to 50 / sqrt(4 x 600,000) = 0.03 levels; half a level is cut off.
  UnevenGainSceneConfig even;
  even.gradient = 0;
  even.contrast = 1;
  even.shadow = 1;
  const SonarScene scene = simulate_uneven_gain_scene(even, Rng(5));
  cv::Scalar mean, deviation;
  cv::meanStdDev(scene.image.intensity, mean, deviation);
  EXPECT_NEAR(mean[0], 49.5, 0.15);
  EXPECT_NEAR(deviation[0], 25, 0.15);
}

TEST(SonarSceneTest, ScenesAreAsTheirConfigurationSays) {
  for (const Case& one : cases()) {
    const SonarScene scene = simulate_spotted_scene(one.scene, Rng(7));
    EXPECT_EQ(scene.image.intensity.size(), cv::Size(one.scene.columns, one.scene.rows));
    EXPECT_NO_THROW(check_sonar_image(scene.image));
    EXPECT_EQ(scene.image.valid.empty(), !one.scene.fan);
    EXPECT_NEAR(cv::mean(scene.image.intensity, scene.object)[0], 0.92 * one.scene.object_level, 0.1 * one.scene.object_level);
    std::vector<cv::Point> points;
    cv::findNonZero(scene.object, points);
    const cv::Size2f sides = cv::minAreaRect(points).size;
    const double length = std::max(sides.width, sides.height);
    EXPECT_NEAR(length, one.scene.object_length_px, 0.1 * one.scene.object_length_px) << one.name;
  }
}

TEST(SonarSceneTest, TheSameSeedGivesTheSameSceneAndSpotsMoveNothingElse) {
  const SonarScene scene = simulate_spotted_scene(branch_scene(), Rng(9));
  const SonarScene again = simulate_spotted_scene(branch_scene(), Rng(9));
  const SonarScene other = simulate_spotted_scene(branch_scene(), Rng(10));
  SpottedSceneConfig clean = branch_scene();
  clean.spots = 0;
  const SonarScene without = simulate_spotted_scene(clean, Rng(9));
  EXPECT_EQ(cv::countNonZero(scene.image.intensity != again.image.intensity), 0);
  EXPECT_GT(cv::countNonZero(scene.image.intensity != other.image.intensity), 0);
  EXPECT_EQ(cv::countNonZero(scene.object != without.object), 0);
  const int differing = cv::countNonZero(scene.image.intensity != without.image.intensity);
  EXPECT_GT(differing, 350);
  EXPECT_LT(differing, 350 * 8);  // 350 spots of 6 px on average
  clean.looks = 0;
  EXPECT_THROW((void)simulate_spotted_scene(clean, Rng(1)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
