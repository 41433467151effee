/// How well detected regions meet the truth. [yuan2016] sections 3.4 and 3.5, docs/math/regions.md to
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/ground_truth.hpp"
#include "ssjs/imaging/regions.hpp"

namespace ssjs {

/// The paper's Tables 1 to 8: what is counted are regions (or their centroids), among those that are not objects too. A ratio
/// without a denominator has no value. Matrices of many pictures add up, and know TN if all do.
struct ConfusionMatrix {
  std::int64_t true_positives = 0;             ///< detected regions of objects
  std::int64_t false_positives = 0;            ///< detected regions of no object
  std::int64_t false_negatives = 0;            ///< objects without a region
  std::optional<std::int64_t> true_negatives;  ///< candidates away from objects that were not detected; none: the candidates are not known

  [[nodiscard]] std::optional<double> false_positive_rate() const;  ///< FP / (FP + TN), (R-20); none without TN
  [[nodiscard]] std::optional<double> precision() const;            ///< TP / (TP + FP), the positive predictive value, (R-21)
  [[nodiscard]] std::optional<double> recall() const;               ///< TP / (TP + FN), (R-22)
  ConfusionMatrix& operator+=(const ConfusionMatrix& other);
};

/// Which regions are an object's.
enum class RegionMatch {
  kCentroid,  ///< those whose centroid, rounded to a pixel, lies on it
  kMajority,  ///< those with more than half of their pixels on it
};

inline const Choices<RegionMatch> kRegionMatches = {{"centroid", RegionMatch::kCentroid}, {"majority", RegionMatch::kMajority}};

struct SegmentationScoreConfig {
  RegionMatch match = RegionMatch::kCentroid;
  double hit_iou = 0.3;
  CentroidWeighting weighting = CentroidWeighting::kRegions;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("match", match, kRegionMatches, "which regions are an object's: by their centroid, or by most of their pixels");
    v.field("hit_iou", hit_iou, Rule::closed(0, 1), "an object is hit by a region whose intersection over union with it is larger");
    v.choice("weighting", weighting, kCentroidWeightings, "centroid of an object: mean over its regions, or over their pixels");
  }
};

struct ObjectScore {
  std::vector<int> labels;                  ///< its regions, ascending; several objects may share one where boxes overlap
  double best_iou = 0;                      ///< of any single region with it, (R-23)
  std::optional<double> centroid_error_px;  ///< none without a region, (R-26)
};

struct SegmentationScore {
  ConfusionMatrix confusion;  ///< true_negatives: none without a pool
  std::vector<ObjectScore> objects;
  std::int64_t hits = 0;             ///< objects with a best_iou above hit_iou, (R-24)
  std::int64_t false_area_px = 0;    ///< detected pixels on no object, (R-27)
  std::int64_t background_px = 0;    ///< pixels of the picture on no object
  std::int64_t intersection_px = 0;  ///< detected pixels on objects
  std::int64_t union_px = 0;
  std::optional<double> mask_iou;                ///< intersection / union, (R-25); none for boxes, and if both are empty
  std::optional<double> pixel_recall;            ///< intersection / pixels on objects, (R-25); none for boxes, and without objects
  std::optional<double> mean_centroid_error_px;  ///< over the objects that have a region

  [[nodiscard]] std::optional<double> hit_rate() const;             ///< hits / objects
  [[nodiscard]] std::optional<double> false_area_fraction() const;  ///< false area / background
};

/// pool: CV_8U of the picture's size, the components of which are the candidates that a detector could have taken for objects (the
/// foreground of one Otsu pass, say); empty: none are known. Throws InvalidArgument where sizes differ.
[[nodiscard]] SegmentationScore segmentation_score(const LabelledRegions& detected, const GroundTruth& truth, const cv::Mat& pool,
                                                   const SegmentationScoreConfig& config);

}  // namespace ssjs
