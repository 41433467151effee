/// A trained cascade of boosted Haar features: what it is made of, and what it says about one window. [viola2004], thesis 4.3.2,
/// docs/math/cascade.md (C-12), (C-13).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/cascade/contour_reference.hpp"
#include "ssjs/cascade/haar_feature.hpp"

namespace ssjs {

/// One decision: value < threshold goes on at `left`, otherwise at `right`; numbers above 0 are nodes of the same tree, others
/// are its leaves, negated.
struct TreeNode {
  int feature = 0;
  float threshold = 0;
  int left = 0;
  int right = -1;
  friend bool operator==(const TreeNode& a, const TreeNode& b) {
    return a.feature == b.feature && a.threshold == b.threshold && a.left == b.left && a.right == b.right;
  }
};

/// A decision tree; a stump has one node and two leaves.
struct WeakClassifier {
  std::vector<TreeNode> nodes;
  std::vector<float> leaves;
  friend bool operator==(const WeakClassifier& a, const WeakClassifier& b) { return a.nodes == b.nodes && a.leaves == b.leaves; }
};

struct CascadeStage {
  std::vector<WeakClassifier> weak;
  float threshold = 0;
  friend bool operator==(const CascadeStage& a, const CascadeStage& b) { return a.weak == b.weak && a.threshold == b.threshold; }
};

/// One line of the validation curve: rates are cumulative over the layers up to this one.
struct LayerRecord {
  int features = 0;                  ///< weak classifiers in this layer
  double detection_rate = 0;         ///< of the validation objects, passed by all layers so far
  double false_positive_rate = 0;    ///< of the validation negatives
  double target_detection_rate = 0;  ///< from the plan
  double target_false_positive_rate = 0;
  int negatives = 0;               ///< trained on
  double negatives_looked_at = 0;  ///< windows examined to find the mined ones among them
  friend bool operator==(const LayerRecord& a, const LayerRecord& b) {
    return a.features == b.features && a.detection_rate == b.detection_rate && a.false_positive_rate == b.false_positive_rate &&
           a.target_detection_rate == b.target_detection_rate && a.target_false_positive_rate == b.target_false_positive_rate &&
           a.negatives == b.negatives && a.negatives_looked_at == b.negatives_looked_at;
  }
};

/// Where a model comes from. Empty for models that others trained.
struct Provenance {
  std::string trained_with;                                   ///< program and version
  std::vector<std::pair<std::string, std::string>> settings;  ///< of the training, data digests among them
  std::vector<LayerRecord> layers;
  std::string stopped_because;
  friend bool operator==(const Provenance& a, const Provenance& b) {
    return a.trained_with == b.trained_with && a.settings == b.settings && a.layers == b.layers && a.stopped_because == b.stopped_because;
  }
};

struct HaarCascade {
  cv::Size window;
  std::vector<HaarFeature> features;
  std::vector<CascadeStage> stages;
  Provenance provenance;
  std::optional<ContourReference> contour;  ///< of the objects trained on, to verify detections with
  friend bool operator==(const HaarCascade& a, const HaarCascade& b) {
    return a.window == b.window && a.features == b.features && a.stages == b.stages && a.provenance == b.provenance &&
           a.contour == b.contour;
  }
};

/// Throws InvalidArgument unless all numbers are finite, all features lie in the window and all trees end: children stand after
/// their parents, every leaf exists.
void check_cascade(const HaarCascade& cascade);

/// The cascade for the other side of the vehicle, where echo and shadow change places. Throws InvalidArgument if a tilted feature
/// has no mirror image; CascadeDetector mirrors the picture instead and knows no exception.
[[nodiscard]] HaarCascade mirrored(const HaarCascade& cascade);

/// What a stage needs at least: sums are compared with its threshold less a hundred-thousandth, as OpenCV does.
[[nodiscard]] float pass_mark(const CascadeStage& stage);

/// (C-12): the stage's sum in the window at `top_left`.
[[nodiscard]] double stage_sum(const CascadeStage& stage, const std::vector<HaarFeature>& features, const IntegralImage& image,
                               cv::Point top_left, float norm);

struct WindowVerdict {
  int stages_passed = 0;  ///< -1: too flat to be looked at
  double score = 0;       ///< (C-13): sum over the stages run of what each had above its pass mark
};
[[nodiscard]] WindowVerdict judge_window(const HaarCascade& cascade, const IntegralImage& image, cv::Point top_left);

}  // namespace ssjs
