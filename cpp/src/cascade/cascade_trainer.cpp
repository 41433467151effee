#include "ssjs/cascade/cascade_trainer.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/base/version.hpp"
#include "ssjs/cascade/cascade_file.hpp"
#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/window_sums.hpp"

namespace ssjs {
namespace {

std::string trained_otherwise(const std::string& key, const std::string& before, const std::string& now) {
  std::string what = "was trained with ";
  what.append(key).append(" = ").append(before).append(", not ").append(now);
  return what.append("; train as before, or without --resume");
}

constexpr std::size_t kBytesInMegabyte = 1000000;
constexpr double kLeastShareOfNegatives = 0.1;  // of those wanted: with fewer a layer would learn single windows by heart
constexpr double kLessThanOne = 0.5;
constexpr double kAsymmetryStep = 8;
constexpr int kFewStumps = 8;
constexpr double kShiftStep = 0.125;

std::string text(double number) {
  std::ostringstream out;
  out.precision(12);
  out << number;
  return out.str();
}

/// A stump in the place where boosting put it, and moved by 1, 2, ... steps towards accepting.
struct MovableStump {
  HaarFeature feature;
  std::vector<float> thresholds;
  float left = 0;
  float right = 0;
};

/// Sums of a growing stage over some windows, for each of the moves.
class StageSums {
 public:
  StageSums(std::size_t windows, std::size_t moves) : sums_(moves, std::vector<double>(windows, 0.0)) {}
  void add(const MovableStump& stump, const std::vector<float>& values) {
    for (std::size_t m = 0; m < sums_.size(); ++m)
      for (std::size_t i = 0; i < values.size(); ++i)
        sums_[m][i] += static_cast<double>(values[i] < stump.thresholds[m] ? stump.left : stump.right);
  }
  [[nodiscard]] const std::vector<double>& of_move(std::size_t move) const { return sums_[move]; }

 private:
  std::vector<std::vector<double>> sums_;
};

/// The windows of a set, and which of them have passed all layers so far.
class Followed {
 public:
  Followed(const WindowSet& windows, WindowSums::Diagonal diagonal) : windows_(windows, diagonal), standing_(windows.size()), sums_(0, 0) {
    for (std::size_t i = 0; i < standing_.size(); ++i) standing_[i] = !windows_.is_flat(i);
  }

  void begin_layer(std::size_t moves) { sums_ = StageSums(standing_.size(), moves); }
  void add(const MovableStump& stump) {
    values_.resize(standing_.size());
    windows_.values(stump.feature, values_.data());
    sums_.add(stump, values_);
  }
  /// A finished layer.
  void pass(const CascadeStage& stage, const std::vector<HaarFeature>& features) {
    begin_layer(1);
    for (const WeakClassifier& stump : stage.weak) {
      const TreeNode& node = stump.nodes[0];
      add({features[static_cast<std::size_t>(node.feature)], {node.threshold}, stump.leaves[0], stump.leaves[1]});
    }
    const auto mark = static_cast<double>(pass_mark(stage));
    for (std::size_t i = 0; i < standing_.size(); ++i) standing_[i] = standing_[i] && sums_.of_move(0)[i] >= mark;
  }

  /// Share of all windows that stand after a layer with this pass mark.
  [[nodiscard]] double rate_at(float mark, std::size_t move) const {
    const std::vector<double>& sums = sums_.of_move(move);
    std::size_t passed = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) passed += standing_[i] && sums[i] >= static_cast<double>(mark) ? 1 : 0;
    return static_cast<double>(passed) / static_cast<double>(sums.size());
  }
  /// (C-17): the highest threshold that leaves at least `rate` of all windows standing, or all that still do.
  [[nodiscard]] float threshold_for(double rate, std::size_t move) const {
    std::vector<double> sums;
    for (std::size_t i = 0; i < standing_.size(); ++i)
      if (standing_[i]) sums.push_back(sums_.of_move(move)[i]);
    if (sums.empty()) return 0;
    const auto needed = static_cast<std::size_t>(std::ceil(rate * static_cast<double>(standing_.size()) - 1e-9));
    const auto place = sums.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(needed, 1, sums.size()) - 1);
    std::nth_element(sums.begin(), place, sums.end(), std::greater<>());
    const auto threshold = static_cast<float>(*place);
    return static_cast<double>(threshold) <= *place ? threshold : std::nextafter(threshold, -INFINITY);
  }
  [[nodiscard]] std::vector<std::size_t> standing() const {
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < standing_.size(); ++i)
      if (standing_[i]) indices.push_back(i);
    return indices;
  }

 private:
  WindowSums windows_;
  std::vector<bool> standing_;
  StageSums sums_;
  std::vector<float> values_;
};

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

class Trainer {
 public:
  Trainer(const CascadeTrainingData& data, const TrainingPlan& plan, const CascadeTrainerConfig& config, int threads,
          const TrainingProgressSink& progress)
      : data_(data),
        plan_(plan),
        config_(config),
        threads_(threads),
        progress_(progress),
        rng_(static_cast<std::uint64_t>(config.seed)),
        all_features_(enumerate_features(config.feature_set, data.positives.window())),
        objects_(data.positives, diagonal()),
        negatives_(data.negatives, diagonal()) {
    if (data.validation_positives.size() > 0) validation_objects_ = std::make_unique<Followed>(data.validation_positives, diagonal());
    if (data.validation_negatives.size() > 0) validation_negatives_ = std::make_unique<Followed>(data.validation_negatives, diagonal());
    cascade_.window = data.positives.window();
    cascade_.provenance.trained_with = "ssjs " + std::string(kVersion);
    cascade_.provenance.settings = settings();
    wanted_ = config.negatives_per_layer ? static_cast<std::size_t>(*config.negatives_per_layer) : 2 * data.positives.size();
  }

  void resume_from(const std::string& path) {
    HaarCascade found = load_cascade(path);
    if (found.window != cascade_.window || found.provenance.trained_with != cascade_.provenance.trained_with)
      throw FileError(path, 0,
                      "was trained by " + found.provenance.trained_with + " or for another window; train anew, or without --resume");
    for (std::size_t i = 0; i < cascade_.provenance.settings.size(); ++i) {
      const auto& [key, value] = cascade_.provenance.settings[i];
      const bool known = i < found.provenance.settings.size() && found.provenance.settings[i].first == key;
      if (!known || found.provenance.settings[i].second != value)
        throw FileError(path, 0, trained_otherwise(key, known ? found.provenance.settings[i].second : "nothing", value));
    }
    cascade_ = std::move(found);
    for (const CascadeStage& stage : cascade_.stages) for_each_followed([&](Followed& windows) { windows.pass(stage, cascade_.features); });
    if (!cascade_.provenance.layers.empty()) false_positive_rate_ = cascade_.provenance.layers.back().false_positive_rate;
    cascade_.provenance.stopped_because.clear();
  }

  HaarCascade run(const std::optional<std::string>& checkpoint) {
    std::string& reason = cascade_.provenance.stopped_because;
    while (reason.empty() && cascade_.stages.size() < plan_.size()) {
      reason = train_layer();
      if (reason.empty() && cascade_.stages.size() == plan_.size()) reason = "the plan is at its end";
      if (checkpoint && !cascade_.stages.empty()) save_cascade(cascade_, *checkpoint);
    }
    if (reason.empty()) reason = "the plan is at its end";
    if (cascade_.stages.empty()) throw InvalidArgument("training", "no layer", reason);
    if (checkpoint) save_cascade(cascade_, *checkpoint);
    return std::move(cascade_);
  }

 private:
  [[nodiscard]] WindowSums::Diagonal diagonal() const {
    return config_.feature_set == FeatureSet::kAll ? WindowSums::Diagonal::kWith : WindowSums::Diagonal::kWithout;
  }

  template <class Act>
  void for_each_followed(const Act& act) {
    act(objects_);
    act(negatives_);
    if (validation_objects_) act(*validation_objects_);
    if (validation_negatives_) act(*validation_negatives_);
  }

  [[nodiscard]] std::vector<std::pair<std::string, std::string>> settings() const {
    std::vector<std::pair<std::string, std::string>> found = {
        {"feature_set", to_string(config_.feature_set)},
        {"boost", to_string(config_.boost)},
        {"negatives_per_layer", config_.negatives_per_layer ? std::to_string(*config_.negatives_per_layer) : "twice the objects"},
        {"mining_scale_factor", text(config_.mining_scale_factor)},
        {"min_improvement", text(config_.min_improvement)},
        {"max_asymmetry", text(config_.max_asymmetry)},
        {"max_shift", text(config_.max_shift)},
        {"seed", std::to_string(config_.seed)},
        {"negative_images", std::to_string(data_.negative_images.count) + " " + data_.negative_images_digest}};
    const auto add_windows = [&](const std::string& name, const WindowSet& windows) {
      std::ostringstream out;
      out << windows.size() << " " << std::hex << windows.digest();
      found.emplace_back(name, out.str());
    };
    add_windows("positives", data_.positives);
    add_windows("validation_positives", data_.validation_positives);
    add_windows("negatives", data_.negatives);
    add_windows("validation_negatives", data_.validation_negatives);
    for (std::size_t k = 0; k < plan_.size(); ++k)
      found.emplace_back("layer " + std::to_string(k + 1), text(plan_[k].detection_rate) + " " + text(plan_[k].false_positive_rate) + " " +
                                                               std::to_string(plan_[k].max_features));
    return found;
  }

  void report(const std::string& doing, int features) const {
    if (!progress_) return;
    const std::size_t layer = cascade_.stages.size();
    double done = features;
    double all = 0;
    for (std::size_t k = 0; k < plan_.size(); ++k) {
      all += plan_[k].max_features;
      if (k < layer) done += plan_[k].max_features;
    }
    if (!progress_({static_cast<int>(layer) + 1, static_cast<int>(plan_.size()), doing, features, plan_[layer].max_features, done / all}))
      throw Cancelled();
  }

  /// The windows without object that pass so far: those given first, then as many as are wanted from the pictures.
  [[nodiscard]] MinedNegatives negatives_of_layer() const {
    MinedNegatives found{data_.negatives.select(negatives_.standing()), 0, 0, 0};
    if (found.windows.size() >= wanted_) return found;
    MinedNegatives mined = mine_negatives(cascade_, data_.negative_images, wanted_ - found.windows.size(), config_.mining_scale_factor,
                                          rng_, "mining for layer " + std::to_string(cascade_.stages.size() + 1), threads_);
    found.windows.append(mined.windows);
    mined.windows = std::move(found.windows);
    return mined;
  }

  [[nodiscard]] bool reaches(const LayerTarget& target, const LayerRecord& record) const {
    return record.false_positive_rate <= target.false_positive_rate &&
           record.false_positive_rate <= target.false_alarm_rate * false_positive_rate_;
  }

  struct Attempt {
    CascadeStage stage;
    std::vector<HaarFeature> features;  ///< of the whole cascade with this stage
    LayerRecord record;
  };

  /// Stumps until the target is reached or their number is. A lost object weighs `asymmetry` times a false alarm, in equal parts
  /// over the rounds. [viola2002]
  Attempt grow_stage(const FeatureTable& table, const LayerTarget& target, double asymmetry) {
    const std::size_t objects = table.positives();
    const auto negatives = static_cast<double>(table.samples() - objects);
    // (C-16)
    std::vector<double> weights(table.samples());
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i < objects ? 0.5 / static_cast<double>(objects) : 0.5 / negatives;
    const double for_objects = std::pow(asymmetry, 1.0 / target.max_features);
    const std::size_t moves = static_cast<std::size_t>(config_.max_shift / kShiftStep) + 1;
    for_each_followed([&](Followed& windows) { windows.begin_layer(moves); });
    StageSums sums(table.samples(), moves);
    std::vector<float> values(table.samples());
    std::vector<MovableStump> stumps;
    Attempt attempt{{}, {}, {0, 0, 1, target.detection_rate, target.false_positive_rate, 0, 0}};
    while (attempt.record.features < target.max_features && !(attempt.record.features > 0 && reaches(target, attempt.record))) {
      report("boosting", attempt.record.features);
      for (std::size_t i = 0; i < objects; ++i) weights[i] *= for_objects;
      const auto stump = best_stump(table, weights, config_.boost, threads_);
      if (!stump) break;
      table.values(stump->feature, values.data());
      MovableStump movable{table.feature(stump->feature), {}, stump->left, stump->right};
      const double step = (stump->left > stump->right ? kShiftStep : -kShiftStep) * deviation(values, objects);
      for (std::size_t m = 0; m < moves; ++m)
        movable.thresholds.push_back(static_cast<float>(static_cast<double>(stump->threshold) + static_cast<double>(m) * step));
      // once the samples are told apart without a fault, boosting has nothing more to say
      if (!stumps.empty() && stumps.back().feature == movable.feature && stumps.back().thresholds[0] == movable.thresholds[0]) break;
      double sum_of_weights = 0;
      for (std::size_t i = 0; i < weights.size(); ++i) {
        const auto answer = static_cast<double>(values[i] < stump->threshold ? stump->left : stump->right);
        weights[i] *= std::exp(i < objects ? -answer : answer);
        sum_of_weights += weights[i];
      }
      for (double& weight : weights) weight /= sum_of_weights;
      sums.add(movable, values);
      for_each_followed([&](Followed& windows) { windows.add(movable); });
      stumps.push_back(std::move(movable));
      settle(stumps, target, sums, objects, attempt);
    }
    return attempt;
  }

  /// (C-17): the greatest move with which the target is reached, which leaves objects not seen yet the most room; if there is none,
  /// the one that lets the fewest windows without object pass. The objects judged by pass with either.
  void settle(const std::vector<MovableStump>& stumps, const LayerTarget& target, const StageSums& sums, std::size_t objects,
              Attempt& attempt) const {
    const Followed& judges = validation_objects_ ? *validation_objects_ : objects_;
    std::optional<std::size_t> best;
    attempt.record.features = static_cast<int>(stumps.size());
    for (std::size_t m = 0; m < stumps[0].thresholds.size(); ++m) {
      CascadeStage stage;
      stage.threshold = judges.threshold_for(target.detection_rate, m);
      const float mark = pass_mark(stage);
      double false_positive_rate = 0;
      if (validation_negatives_) {
        false_positive_rate = validation_negatives_->rate_at(mark, m);
      } else {
        const auto first = sums.of_move(m).begin() + static_cast<std::ptrdiff_t>(objects);
        const auto passed = std::count_if(first, sums.of_move(m).end(), [&](double sum) { return sum >= static_cast<double>(mark); });
        // none of n says no more than less than one in n
        const auto negatives = static_cast<double>(sums.of_move(m).size() - objects);
        false_positive_rate = false_positive_rate_ * std::max(static_cast<double>(passed), kLessThanOne) / negatives;
      }
      LayerRecord record = attempt.record;
      record.false_positive_rate = false_positive_rate;
      record.detection_rate = judges.rate_at(mark, m);
      const bool reached = reaches(target, record);
      if (best && !reached && (reaches(target, attempt.record) || false_positive_rate >= attempt.record.false_positive_rate)) continue;
      best = m;
      attempt.record = record;
      attempt.stage.threshold = stage.threshold;
    }
    attempt.features = cascade_.features;
    attempt.stage.weak.clear();
    for (const MovableStump& stump : stumps)
      attempt.stage.weak.push_back(
          {{{index_of(stump.feature, attempt.features), stump.thresholds[*best], 0, -1}}, {stump.left, stump.right}});
  }

  /// Adds a layer, or says why not.
  std::string train_layer() {
    if (false_positive_rate_ == 0) return "no validation window without object passes any more: a further layer could not be judged";
    const LayerTarget& target = plan_[cascade_.stages.size()];
    report("mining", 0);
    const MinedNegatives mined = negatives_of_layer();
    if (static_cast<double>(mined.windows.size()) < kLeastShareOfNegatives * static_cast<double>(wanted_))
      return "only " + std::to_string(mined.windows.size()) + " windows without object still pass, " + std::to_string(wanted_) +
             " are wanted: the pictures without objects are used up";
    report("features", 0);
    const WindowSet objects = data_.positives.select(objects_.standing());
    const FeatureTable table(all_features_, objects, mined.windows, static_cast<std::size_t>(config_.memory_mb) * kBytesInMegabyte,
                             threads_);
    if (table.positives() == 0 || table.positives() == table.samples())
      return "no window is left of one of the two kinds, but for flat ones";

    std::optional<Attempt> best;
    // The sum of few stumps has few values: with plain weights the least of them may be all that keeps nearly every object.
    for (double asymmetry = 1; asymmetry <= config_.max_asymmetry; asymmetry *= kAsymmetryStep) {
      Attempt attempt = grow_stage(table, target, asymmetry);
      if (attempt.stage.weak.empty()) return "no feature tells the objects from the rest";
      attempt.record.negatives = static_cast<int>(mined.windows.size());
      attempt.record.negatives_looked_at = mined.windows_looked_at;
      const bool reached = reaches(target, attempt.record);
      if (!best || attempt.record.false_positive_rate < best->record.false_positive_rate) best = std::move(attempt);
      if (reached || target.max_features > kFewStumps) break;
    }
    const LayerRecord& record = best->record;
    // (C-18)
    if (record.false_positive_rate > (1 - config_.min_improvement) * false_positive_rate_)
      return "a further layer of " + std::to_string(record.features) + " features does not help: false positive rate " +
             text(record.false_positive_rate) + " after it, " + text(false_positive_rate_) + " before";
    for_each_followed([&](Followed& windows) { windows.pass(best->stage, best->features); });
    false_positive_rate_ = record.false_positive_rate;
    cascade_.provenance.layers.push_back(record);
    cascade_.features = std::move(best->features);
    cascade_.stages.push_back(std::move(best->stage));
    return "";
  }

  const CascadeTrainingData& data_;
  const TrainingPlan& plan_;
  const CascadeTrainerConfig& config_;
  int threads_;
  const TrainingProgressSink& progress_;
  Rng rng_;
  std::vector<HaarFeature> all_features_;
  Followed objects_;
  Followed negatives_;
  std::unique_ptr<Followed> validation_objects_;
  std::unique_ptr<Followed> validation_negatives_;
  std::size_t wanted_ = 0;
  double false_positive_rate_ = 1;
  HaarCascade cascade_;
};

void check_data(const CascadeTrainingData& data) {
  if (data.positives.size() < 2)
    throw InvalidArgument("positives", static_cast<double>(data.positives.size()), "at least two objects are needed");
  if (data.negatives.size() == 0 && data.negative_images.count == 0)
    throw InvalidArgument("negatives", "none", "windows without object, or pictures to take them from, are needed");
  for (const WindowSet* windows : {&data.validation_positives, &data.negatives, &data.validation_negatives})
    if (windows->size() > 0 && windows->window() != data.positives.window())
      throw InvalidArgument("windows", "of different sizes", "must all be as large as the positives");
}

}  // namespace

HaarCascade train_cascade(const CascadeTrainingData& data, const TrainingPlan& plan, const CascadeTrainerConfig& config, int threads,
                          const std::optional<std::string>& checkpoint, bool resume, const TrainingProgressSink& progress) {
  throw_if_any(violations(config));
  check_plan(plan);
  check_data(data);
  Trainer trainer(data, plan, config, threads, progress);
  if (checkpoint && resume && std::filesystem::exists(*checkpoint)) trainer.resume_from(*checkpoint);
  return trainer.run(checkpoint);
}

}  // namespace ssjs
