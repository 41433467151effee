// Where the improved threshold is the better one, and where not.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "../quantiles.hpp"
#include "imaging/scene_outcome.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

struct Picture {
  const char* name;
  SpottedSceneConfig scene;
  SegmentationConfig segmentation;
};

std::vector<Picture> pictures() {
  std::vector<Picture> all{{"ship", ship_scene(), segmentation_preset(SegmentationPreset::kSideScanHigh)},
                           {"branch", branch_scene(), segmentation_preset(SegmentationPreset::kSideScanLow)},
                           {"body", body_scene(), segmentation_preset(SegmentationPreset::kForwardLooking)}};
  for (Picture& one : all) one.segmentation.improved_otsu.canny_high = 0.33;
  return all;
}

/// Medians over the seeds, and for how many of them the claims hold.
struct Row {
  std::vector<double> spots, spots_without, precision, entropy_precision, error_px, entropy_error_px;
  int fired = 0, shut_without = 0, precision_higher = 0, rate_lower = 0, near = 0, seeds = 0;

  void add(const Picture& one, std::uint64_t seed) {
    const SonarScene scene = simulate_spotted_scene(one.scene, Rng(seed));
    const SceneOutcome improved = outcome(scene, one.segmentation);
    const SceneOutcome entropy = outcome(scene, with_method(one.segmentation, ThresholdMethod::kMaximumEntropy));
    SpottedSceneConfig clean = one.scene;
    clean.spots = 0;
    const SonarScene without = simulate_spotted_scene(clean, Rng(seed));
    const auto plain =
        improved_otsu({power_law(without.image, one.segmentation.power_law), without.image.valid}, one.segmentation.improved_otsu);
    if (!improved.result.improved_otsu || !plain) return;
    ++seeds;
    spots.push_back(static_cast<double>(improved.result.improved_otsu->spots));
    spots_without.push_back(static_cast<double>(plain->spots));
    precision.push_back(improved.precision());
    entropy_precision.push_back(entropy.precision());
    error_px.push_back(improved.centroid_error_px());
    entropy_error_px.push_back(entropy.centroid_error_px());
    fired += improved.result.improved_otsu->second_pass_fired ? 1 : 0;
    shut_without += plain->second_pass_fired ? 0 : 1;
    precision_higher += improved.precision() > entropy.precision() ? 1 : 0;
    rate_lower += improved.false_positive_rate() < entropy.false_positive_rate() ? 1 : 0;
    near += improved.centroid_error_px() <= 2 ? 1 : 0;
  }

  void print(const std::string& name) const {
    std::printf("| %s | %.0f (%.0f) | %d, %d | %d | %d | %.2f (%.2f) | %.2f (%.2f) | %d |\n", name.c_str(), median(spots),
                median(spots_without), fired, shut_without, rate_lower, precision_higher, median(precision), median(entropy_precision),
                median(error_px), median(entropy_error_px), near);
    std::fflush(stdout);
  }
};

}  // namespace

void study_scenes(const SegmentationStudyOptions& options) {
  std::printf(
      "%d seeds each. N_a: median with spots (without). Gate: scenes where it opens, where it stays shut without spots.\n"
      "Then in how many scenes FPR is lower and PPV higher than with maximum entropy; medians of PPV and of the centroid's error, px\n"
      "(of maximum entropy); scenes with an error of at most 2 px.\n\n",
      options.seeds);
  std::printf("| scene | N_a | gate | FPR lower | PPV higher | PPV | error px | <= 2 px |\n|---|---|---|---|---|---|---|---|\n");
  const auto sweep = [&](const std::string& name, const auto& change) {
    for (Picture one : pictures()) {
      change(one.scene);
      Row row;
      for (int seed = 0; seed < options.seeds; ++seed) row.add(one, static_cast<std::uint64_t>(seed));
      row.print(std::string(one.name) + ", " + name);
    }
  };
  sweep("as drawn", [](SpottedSceneConfig&) {});
  for (const double level : {20.0, 40.0, 70.0, 90.0})
    sweep("seabed " + std::to_string(static_cast<int>(level)), [&](SpottedSceneConfig& scene) { scene.background_level = level; });
  for (const int looks : {1, 2, 4}) sweep(std::to_string(looks) + " looks", [&](SpottedSceneConfig& scene) { scene.looks = looks; });
  sweep("seabed 70, 4 looks", [](SpottedSceneConfig& scene) {
    scene.background_level = 70;
    scene.looks = 4;
  });
  for (const double level : {220.0, 200.0, 180.0, 160.0})
    sweep("object " + std::to_string(static_cast<int>(level)), [&](SpottedSceneConfig& scene) { scene.object_level = level; });
  for (const int looks : {4, 1})
    sweep("object of " + std::to_string(looks) + " looks", [&](SpottedSceneConfig& scene) { scene.object_looks = looks; });
}

void study_gain(const SegmentationStudyOptions& options) {
  std::printf("Mean IoU of the largest region over %d seeds, 800 x 800, 4 looks, gain +-60 %%, automatic preset.\n\n", options.seeds);
  std::printf(
      "| Gaussian px | gain | contrast | improved (fired) | Otsu | iterative | entropy | local |\n|---|---|---|---|---|---|---|---|\n");
  struct Gain {
    const char* name;
    GainNormalisation kind;
    int window_px;
  };
  for (const double sigma_px : {0.0, 1.5, 3.0}) {
    for (const Gain& gain :
         {Gain{"none", GainNormalisation::kNone, 129}, Gain{"column median", GainNormalisation::kColumnMedian, 129},
          Gain{"129 px mean", GainNormalisation::kLocalMean, 129}, Gain{"257 px mean", GainNormalisation::kLocalMean, 257}}) {
      for (const double contrast : {2.0, 1.5}) {
        SegmentationConfig config;
        if (sigma_px > 0) config.filter = {SpeckleFilter::kGaussian, 3, sigma_px, 50};
        config.gain.kind = gain.kind;
        config.gain.window_px = gain.window_px;
        UnevenGainSceneConfig uneven;
        uneven.contrast = contrast;
        std::vector<double> mean_iou;
        int fired = 0;
        for (const ThresholdMethod method : {ThresholdMethod::kImprovedOtsu, ThresholdMethod::kOtsu, ThresholdMethod::kIterative,
                                             ThresholdMethod::kMaximumEntropy, ThresholdMethod::kLocal}) {
          std::vector<double> iou;
          for (int seed = 0; seed < options.seeds; ++seed) {
            const SonarScene scene = simulate_uneven_gain_scene(uneven, Rng(static_cast<std::uint64_t>(seed)));
            const SegmentationResult result = segment(scene.image, with_method(config, method));
            if (result.improved_otsu && result.improved_otsu->second_pass_fired) ++fired;
            iou.push_back(largest_region_iou(scene, result));
          }
          mean_iou.push_back(mean(iou));
        }
        std::printf("| %.1f | %s | %.1f | %.2f (%d) | %.2f | %.2f | %.2f | %.2f |\n", sigma_px, gain.name, contrast, mean_iou[0], fired,
                    mean_iou[1], mean_iou[2], mean_iou[3], mean_iou[4]);
        std::fflush(stdout);
      }
    }
  }
}

}  // namespace ssjs::benchmarks
