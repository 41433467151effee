/// What each layer of a cascade is to reach. Thesis 4.3.3, Table 4.1.
#pragma once

#include <vector>

namespace ssjs {

/// Rates are those of the whole cascade up to and including this layer.
struct LayerTarget {
  double detection_rate = 0;
  double false_positive_rate = 0;
  int max_features = 0;
  double false_alarm_rate = 1;  ///< of what reaches this layer, no more than this part passes it
};
using TrainingPlan = std::vector<LayerTarget>;

/// Table 4.1 of the thesis: seven layers from 99.9 % and 50 % with one feature to 99 % and 0.05 % with at most thirty.
[[nodiscard]] TrainingPlan thesis_plan();

/// Each layer keeps `detection_rate` of the objects and `false_positive_rate` of the rest of what reaches it.
[[nodiscard]] TrainingPlan uniform_plan(int layers, double detection_rate, double false_positive_rate, int max_features);

/// Throws InvalidArgument unless there is a layer, rates lie in (0, 1], detection rates and false positive rates do not rise, and
/// every layer has a feature.
void check_plan(const TrainingPlan& plan);

}  // namespace ssjs
