/// How a segmentation does on a simulated scene.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

#include "ssjs/imaging/ground_truth.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/morphology.hpp"
#include "ssjs/imaging/segmentation.hpp"
#include "ssjs/imaging/segmentation_score.hpp"
#include "ssjs/imaging/sonar_scene.hpp"

namespace ssjs {

struct SceneOutcome {
  SegmentationResult result;
  SegmentationScore score;
  [[nodiscard]] double centroid_error_px() const {
    return score.objects.front().centroid_error_px.value_or(std::numeric_limits<double>::infinity());
  }
  [[nodiscard]] double false_positive_rate() const { return score.confusion.false_positive_rate().value_or(0); }
  [[nodiscard]] double precision() const { return score.confusion.precision().value_or(0); }
  [[nodiscard]] std::size_t pieces() const { return score.objects.front().labels.size(); }
};

/// The truth put through the same bridging, dilating and filling: these move centroids by themselves.
/// True negatives: components of the first Otsu pass away from the object that are not detected.
inline SceneOutcome outcome(const SonarScene& scene, const SegmentationConfig& config) {
  SceneOutcome out{segment(scene.image, config), {}};
  const SonarImage contrasted{power_law(scene.image, config.power_law), scene.image.valid};
  const std::optional<int> first = otsu_threshold(histogram(contrasted));
  const cv::Mat pool = first ? foreground(contrasted, *first) : cv::Mat::zeros(scene.object.size(), CV_8U);
  const cv::Mat truth = fill_holes(dilate(bridge(scene.object), config.dilations));
  SegmentationScoreConfig scoring;
  scoring.match = RegionMatch::kMajority;
  scoring.weighting = CentroidWeighting::kArea;
  out.score = segmentation_score(out.result.regions, truth_of_mask(truth), pool, scoring);
  return out;
}

inline SegmentationConfig with_method(SegmentationConfig config, ThresholdMethod method) {
  config.method = method;
  return config;
}

/// Intersection over union of the largest region with the object.
inline double largest_region_iou(const SonarScene& scene, const SegmentationResult& result) {
  const auto& regions = result.regions.regions;
  if (regions.empty()) return 0;
  const auto largest =
      std::max_element(regions.begin(), regions.end(), [](const Region& a, const Region& b) { return a.area_px < b.area_px; });
  const cv::Mat detected = result.regions.labels == largest->label;
  return static_cast<double>(cv::countNonZero(detected & scene.object)) / cv::countNonZero(detected | scene.object);
}

}  // namespace ssjs
