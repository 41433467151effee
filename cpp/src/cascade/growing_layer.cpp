#include "ssjs/cascade/growing_layer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/cascade/rejecting_stumps.hpp"

namespace ssjs {
namespace {

constexpr double kLessThanOne = 0.5;
constexpr double kShiftStep = 0.125;

/// Standard deviation of the first `count` values.
double deviation(const std::vector<float>& values, std::size_t count) {
  double sum = 0;
  double squares = 0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += static_cast<double>(values[i]);
    squares += static_cast<double>(values[i]) * static_cast<double>(values[i]);
  }
  const double mean = sum / static_cast<double>(count);
  return std::sqrt(std::max(0.0, squares / static_cast<double>(count) - mean * mean));
}

int index_of(const HaarFeature& feature, std::vector<HaarFeature>& features) {
  const auto found = std::find(features.begin(), features.end(), feature);
  if (found != features.end()) return static_cast<int>(found - features.begin());
  features.push_back(feature);
  return static_cast<int>(features.size()) - 1;
}

class GrowingLayer {
 public:
  explicit GrowingLayer(const LayerTask& task)
      : task_(task),
        moves_(static_cast<std::size_t>(task.max_shift / kShiftStep) + 1),
        sums_(task.table.samples(), moves_),
        values_(task.table.samples()),
        attempt_{{}, {}, {0, 0, 1, task.target.detection_rate, task.target.false_positive_rate, 0, 0}} {
    task.followed.for_each([&](FollowedWindows& windows) { windows.begin_layer(moves_); });
  }

  [[nodiscard]] bool wants_more() const {
    const int features = attempt_.record.features;
    return features < task_.target.max_features && !(features > 0 && task_.reached(attempt_.record));
  }
  [[nodiscard]] int size() const { return attempt_.record.features; }
  [[nodiscard]] LayerAttempt take() { return std::move(attempt_); }

  /// False if it is the last one again: then the search has nothing more to say.
  bool add(const Stump& stump) {
    task_.table.values(stump.feature, values_.data());
    MovableStump movable{task_.table.feature(stump.feature), {}, stump.left, stump.right};
    const double step = (stump.left > stump.right ? kShiftStep : -kShiftStep) * deviation(values_, task_.table.positives());
    for (std::size_t m = 0; m < moves_; ++m)
      movable.thresholds.push_back(static_cast<float>(static_cast<double>(stump.threshold) + static_cast<double>(m) * step));
    if (!stumps_.empty() && stumps_.back().feature == movable.feature && stumps_.back().thresholds[0] == movable.thresholds[0])
      return false;
    sums_.add(movable, values_);
    task_.followed.for_each([&](FollowedWindows& windows) { windows.add(movable); });
    stumps_.push_back(std::move(movable));
    settle();
    return true;
  }

  /// What the stump added last says of the samples of the table.
  [[nodiscard]] float answer(const Stump& stump, std::size_t sample) const {
    return values_[sample] < stump.threshold ? stump.left : stump.right;
  }

 private:
  /// (C-17): the greatest move with which the target is reached, which leaves objects not seen yet the most room; if there is none,
  /// the one that lets the fewest windows without object pass. The objects judged by pass with either.
  void settle() {
    std::optional<std::size_t> best;
    attempt_.record.features = static_cast<int>(stumps_.size());
    for (std::size_t m = 0; m < moves_; ++m) {
      CascadeStage stage;
      stage.threshold = task_.followed.judges().threshold_for(task_.target.detection_rate, m);
      const float mark = pass_mark(stage);
      LayerRecord record = attempt_.record;
      record.false_positive_rate = false_positive_rate(mark, m);
      record.detection_rate = task_.followed.judges().rate_at(mark, m);
      const bool worse = task_.reached(attempt_.record) || record.false_positive_rate >= attempt_.record.false_positive_rate;
      if (best && !task_.reached(record) && worse) continue;
      best = m;
      attempt_.record = record;
      attempt_.stage.threshold = stage.threshold;
    }
    attempt_.features = task_.features;
    attempt_.stage.weak.clear();
    for (const MovableStump& stump : stumps_)
      attempt_.stage.weak.push_back(
          {{{index_of(stump.feature, attempt_.features), stump.thresholds[*best], 0, -1}}, {stump.left, stump.right}});
  }

  [[nodiscard]] double false_positive_rate(float mark, std::size_t move) const {
    if (task_.followed.validation_negatives) return task_.followed.validation_negatives->rate_at(mark, move);
    const std::vector<double>& sums = sums_.of_move(move);
    const auto first = sums.begin() + static_cast<std::ptrdiff_t>(task_.table.positives());
    const auto passed = std::count_if(first, sums.end(), [&](double sum) { return sum >= static_cast<double>(mark); });
    // none of n says no more than less than one in n
    const auto negatives = static_cast<double>(sums.size() - task_.table.positives());
    return task_.false_positive_rate * std::max(static_cast<double>(passed), kLessThanOne) / negatives;
  }

  const LayerTask& task_;
  std::size_t moves_;
  StageSums sums_;
  std::vector<float> values_;
  std::vector<MovableStump> stumps_;
  LayerAttempt attempt_;
};

}  // namespace

LayerAttempt boosted_layer(const LayerTask& task, double asymmetry) {
  const std::size_t objects = task.table.positives();
  const auto negatives = static_cast<double>(task.table.samples() - objects);
  // (C-16)
  std::vector<double> weights(task.table.samples());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i < objects ? 0.5 / static_cast<double>(objects) : 0.5 / negatives;
  const double for_objects = std::pow(asymmetry, 1.0 / task.target.max_features);
  GrowingLayer layer(task);
  while (layer.wants_more()) {
    task.report(layer.size());
    for (std::size_t i = 0; i < objects; ++i) weights[i] *= for_objects;
    const auto stump = best_stump(task.table, weights, task.boost, task.threads);
    // once the samples are told apart without a fault, boosting has nothing more to say
    if (!stump || !layer.add(*stump)) break;
    double sum_of_weights = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const auto answer = static_cast<double>(layer.answer(*stump, i));
      weights[i] *= std::exp(i < objects ? -answer : answer);
      sum_of_weights += weights[i];
    }
    for (double& weight : weights) weight /= sum_of_weights;
  }
  return layer.take();
}

LayerAttempt rejecting_layer(const LayerTask& task) {
  const double detection_rate = task.followed.judges().rate();
  const double lost = 1 - task.target.detection_rate / std::max(detection_rate, task.target.detection_rate);
  RejectingStumps rejecting(task.table, lost, task.target.max_features, task.threads);
  GrowingLayer greedy(task);
  while (greedy.wants_more()) {
    task.report(greedy.size());
    const auto stump = rejecting.next();
    if (!stump || !greedy.add(*stump)) break;
  }
  LayerAttempt first = greedy.take();
  if (first.stage.weak.size() < 2 || task.reached(first.record)) return first;
  task.report(first.record.features);
  rejecting.refine();
  GrowingLayer refined(task);
  for (const Stump& stump : rejecting.stumps())
    if (!refined.wants_more() || !refined.add(stump)) break;
  LayerAttempt second = refined.take();
  return second.record.false_positive_rate < first.record.false_positive_rate ? second : first;
}

}  // namespace ssjs
