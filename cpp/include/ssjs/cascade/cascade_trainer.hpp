/// Training of a cascade, layer by layer. [viola2004], thesis 4.3.3, docs/math/cascade.md (C-16) to (C-18).
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "ssjs/base/config_field.hpp"
#include "ssjs/cascade/haar_cascade.hpp"
#include "ssjs/cascade/negative_miner.hpp"
#include "ssjs/cascade/stump_search.hpp"
#include "ssjs/cascade/training_plan.hpp"
#include "ssjs/cascade/window_set.hpp"

namespace ssjs {

struct CascadeTrainerConfig {
  FeatureSet feature_set = FeatureSet::kSideScanBasic;
  BoostType boost = BoostType::kGentle;
  std::optional<int> negatives_per_layer;
  double mining_scale_factor = 1.25;
  double min_improvement = 0.02;
  int rejecting_features = 8;
  double max_asymmetry = 1;
  double max_shift = 3.0;
  int memory_mb = 1024;
  int seed = 1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("feature_set", feature_set,
             Choices<FeatureSet>{{"basic", FeatureSet::kBasic},
                                 {"core", FeatureSet::kCore},
                                 {"all", FeatureSet::kAll},
                                 {"side_scan", FeatureSet::kSideScan},
                                 {"side_scan_basic", FeatureSet::kSideScanBasic}},
             "features to choose from");
    v.choice("boost", boost, Choices<BoostType>{{"gentle", BoostType::kGentle}, {"discrete", BoostType::kDiscrete}}, "kind of AdaBoost");
    v.field("negatives_per_layer", negatives_per_layer, Rule::at_least(1),
            "windows without object per layer; none: twice as many as objects");
    v.field("mining_scale_factor", mining_scale_factor, Rule{1.0, 4.0, true, false},
            "between the scales at which false alarms are looked for");
    v.field("min_improvement", min_improvement, Rule::open(0, 1),
            "a layer that lowers the false positive rate by a lesser part ends the training");
    v.field("rejecting_features", rejecting_features, Rule::not_negative(),
            "a layer of at most so many features that boosting leaves short of its target is tried with stumps that each reject the most");
    v.field("max_asymmetry", max_asymmetry, Rule::at_least(1),
            "a layer of at most eight features that still misses it is boosted anew with objects that weigh 8, 64, ... up to so much");
    v.field("max_shift", max_shift, Rule::closed(0, 10),
            "deviations of the objects' feature values by which the stumps of a layer may be moved towards accepting");
    v.field("memory_mb", memory_mb, Rule::at_least(1),
            "for the binned feature values; what does not fit is computed anew, with the same result");
    v.field("seed", seed, Rule::not_negative(), "of the windows drawn from the pictures without objects");
  }
};

struct CascadeTrainingData {
  WindowSet positives;                 ///< objects
  WindowSet validation_positives;      ///< of other recordings; empty: the objects trained on serve
  WindowSet negatives;                 ///< windows without object that every layer tries first; may be empty
  WindowSet validation_negatives;      ///< empty: the false positive rate is estimated layer by layer on the windows trained on
  NegativeImages negative_images;      ///< mined for the rest
  std::string negative_images_digest;  ///< of their content, for the model's provenance and --resume
};

struct TrainingProgress {
  int layer = 0;         ///< from 1
  int layers = 0;        ///< of the plan
  std::string doing;     ///< "mining", "features", "boosting"
  int features = 0;      ///< found in this layer
  int max_features = 0;  ///< of this layer
  double fraction = 0;   ///< of the plan's features
};
/// Called now and then; returning false asks the training to stop (it throws Cancelled).
using TrainingProgressSink = std::function<bool(const TrainingProgress&)>;

/// The cascade after the last layer that helped; provenance.stopped_because says why there is no further one.
///
/// With a `checkpoint` path the model so far is written there after each layer. With `resume`, a model found there is carried on:
/// the result is byte for byte that of a training without a break. Throws FileError if it was trained with other data, another
/// plan or other settings. The result does not depend on `threads`.
[[nodiscard]] HaarCascade train_cascade(const CascadeTrainingData& data, const TrainingPlan& plan, const CascadeTrainerConfig& config,
                                        int threads, const std::optional<std::string>& checkpoint = std::nullopt, bool resume = false,
                                        const TrainingProgressSink& progress = {});

}  // namespace ssjs
