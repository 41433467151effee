#include "ssjs/cascade/training_plan.hpp"

#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

TrainingPlan thesis_plan() {
  return {{0.999, 0.5, 1}, {0.997, 0.2, 2}, {0.996, 0.1, 6}, {0.995, 0.05, 11}, {0.995, 0.01, 20}, {0.993, 0.005, 30}, {0.99, 0.0005, 30}};
}

TrainingPlan uniform_plan(int layers, double detection_rate, double false_positive_rate, int max_features) {
  TrainingPlan plan;
  for (int k = 1; k <= layers; ++k)
    plan.push_back({std::pow(detection_rate, k), std::pow(false_positive_rate, k), max_features, false_positive_rate});
  check_plan(plan);
  return plan;
}

void check_plan(const TrainingPlan& plan) {
  if (plan.empty()) throw InvalidArgument("plan", "no layer", "must have at least one");
  for (std::size_t k = 0; k < plan.size(); ++k) {
    const LayerTarget& layer = plan[k];
    const std::string name = "plan, layer " + std::to_string(k + 1);
    for (const double rate : {layer.detection_rate, layer.false_positive_rate, layer.false_alarm_rate})
      if (!(rate > 0 && rate <= 1)) throw InvalidArgument(name, rate, "rates must lie in (0, 1]");
    if (layer.max_features < 1) throw InvalidArgument(name, layer.max_features, "max_features must be at least 1");
    if (k == 0) continue;
    if (layer.detection_rate > plan[k - 1].detection_rate)
      throw InvalidArgument(name, layer.detection_rate, "detection rates are cumulative: a further layer cannot raise them");
    if (layer.false_positive_rate > plan[k - 1].false_positive_rate)
      throw InvalidArgument(name, layer.false_positive_rate, "false positive rates are cumulative: a further layer cannot raise them");
  }
}

}  // namespace ssjs
