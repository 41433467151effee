/// One layer of a cascade in the making: stumps are added until it reaches what the plan asks. docs/math/cascade.md (C-16), (C-17), (C-21).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/followed_windows.hpp"
#include "ssjs/cascade/haar_cascade.hpp"
#include "ssjs/cascade/stump_search.hpp"
#include "ssjs/cascade/training_plan.hpp"

namespace ssjs {

/// The sets of windows that a training follows through its cascade. Those of validation may be missing.
struct FollowedSets {
  FollowedWindows objects;
  FollowedWindows negatives;
  std::unique_ptr<FollowedWindows> validation_objects;
  std::unique_ptr<FollowedWindows> validation_negatives;

  /// The objects by which detection rates are measured.
  [[nodiscard]] const FollowedWindows& judges() const { return validation_objects ? *validation_objects : objects; }
  template <class Act>
  void for_each(const Act& act) {
    act(objects);
    act(negatives);
    if (validation_objects) act(*validation_objects);
    if (validation_negatives) act(*validation_negatives);
  }
};

/// What a layer has come to.
struct LayerAttempt {
  CascadeStage stage;
  std::vector<HaarFeature> features;  ///< of the whole cascade with this stage
  LayerRecord record;
};

/// What a layer is grown from, and to what end. All is referred to.
struct LayerTask {
  const FeatureTable& table;
  FollowedSets& followed;
  const LayerTarget& target;
  const std::vector<HaarFeature>& features;  ///< of the layers before
  double false_positive_rate;                ///< after the layers before
  BoostType boost;
  double max_shift;
  int threads;
  const std::function<void(int features)>& report;  ///< called before each search

  [[nodiscard]] bool reached(const LayerRecord& record) const {
    return record.false_positive_rate <= target.false_positive_rate &&
           record.false_positive_rate <= target.false_alarm_rate * false_positive_rate;
  }
};

/// Boosted stumps until the target is reached or their number is. A lost object weighs `asymmetry` times a false alarm, in equal
/// parts over the rounds. [viola2002] No stumps: no feature tells the objects from the rest.
[[nodiscard]] LayerAttempt boosted_layer(const LayerTask& task, double asymmetry);

/// Stumps that each reject the most of what is left while the layer's objects pass; each may lose its part of those that the layer
/// may lose. (C-21)
[[nodiscard]] LayerAttempt rejecting_layer(const LayerTask& task);

}  // namespace ssjs
