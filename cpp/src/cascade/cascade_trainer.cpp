#include "ssjs/cascade/cascade_trainer.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <sstream>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/version.hpp"
#include "ssjs/cascade/cascade_file.hpp"
#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/growing_layer.hpp"
#include "ssjs/cascade/training_provenance.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kBytesInMegabyte = 1000000;
constexpr double kLeastShareOfNegatives = 0.1;  // of those wanted: with fewer a layer would learn single windows by heart
constexpr double kAsymmetryStep = 8;
constexpr int kFewStumps = 8;  // with more of them, boosting finds its way by itself

std::string text(double number) {
  std::ostringstream out;
  out.precision(12);
  out << number;
  return out.str();
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
        followed_{FollowedWindows(data.positives, diagonal()), FollowedWindows(data.negatives, diagonal()),
                  followed_if_any(data.validation_positives), followed_if_any(data.validation_negatives)} {
    cascade_.window = data.positives.window();
    cascade_.provenance.trained_with = "ssjs " + std::string(kVersion);
    cascade_.provenance.settings = training_settings(data, plan, config);
    wanted_ = config.negatives_per_layer ? static_cast<std::size_t>(*config.negatives_per_layer) : 2 * data.positives.size();
  }

  void resume_from(const std::string& path) {
    HaarCascade found = load_cascade(path);
    check_same_training(found, cascade_, path);
    cascade_ = std::move(found);
    for (const CascadeStage& stage : cascade_.stages)
      followed_.for_each([&](FollowedWindows& windows) { windows.pass(stage, cascade_.features); });
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
  [[nodiscard]] std::unique_ptr<FollowedWindows> followed_if_any(const WindowSet& windows) const {
    return windows.size() > 0 ? std::make_unique<FollowedWindows>(windows, diagonal()) : nullptr;
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

  /// As many windows without object that pass so far as are wanted: of those given, evenly, then from the pictures.
  [[nodiscard]] MinedNegatives negatives_of_layer() const {
    std::vector<std::size_t> standing = followed_.negatives.standing();
    const std::size_t given = std::min(standing.size(), wanted_);
    for (std::size_t i = 0; i < given; ++i) standing[i] = standing[i * standing.size() / given];
    standing.resize(given);
    MinedNegatives found{data_.negatives.select(standing), 0, 0, 0};
    if (found.windows.size() >= wanted_) return found;
    MinedNegatives mined = mine_negatives(cascade_, data_.negative_images, wanted_ - found.windows.size(), config_.mining_scale_factor,
                                          rng_, "mining for layer " + std::to_string(cascade_.stages.size() + 1), threads_);
    found.windows.append(mined.windows);
    mined.windows = std::move(found.windows);
    return mined;
  }

  /// The best of what boosting finds and, for layers of few features that miss their target by it, the other ways of growing one:
  /// the sum of few stumps has few values, and the least of them may be all that keeps nearly every object.
  [[nodiscard]] LayerAttempt best_attempt(const LayerTask& task) const {
    LayerAttempt best = boosted_layer(task, 1);
    const auto enough = [&] { return best.stage.weak.empty() || task.reached(best.record); };
    const auto keep_better = [&](LayerAttempt attempt) {
      if (!attempt.stage.weak.empty() && attempt.record.false_positive_rate < best.record.false_positive_rate) best = std::move(attempt);
    };
    if (!enough() && task.target.max_features <= config_.rejecting_features) keep_better(rejecting_layer(task));
    for (double asymmetry = kAsymmetryStep; asymmetry <= config_.max_asymmetry; asymmetry *= kAsymmetryStep)
      if (!enough() && task.target.max_features <= kFewStumps) keep_better(boosted_layer(task, asymmetry));
    return best;
  }

  /// Adds a layer, or says why not.
  std::string train_layer() {
    if (false_positive_rate_ == 0) return "no validation window without object passes any more: a further layer could not be judged";
    report("mining", 0);
    const MinedNegatives mined = negatives_of_layer();
    if (static_cast<double>(mined.windows.size()) < kLeastShareOfNegatives * static_cast<double>(wanted_))
      return "only " + std::to_string(mined.windows.size()) + " windows without object still pass, " + std::to_string(wanted_) +
             " are wanted: the pictures without objects are used up";
    report("features", 0);
    const WindowSet objects = data_.positives.select(followed_.objects.standing());
    const FeatureTable table(all_features_, objects, mined.windows, static_cast<std::size_t>(config_.memory_mb) * kBytesInMegabyte,
                             threads_);
    if (table.positives() == 0 || table.positives() == table.samples())
      return "no window is left of one of the two kinds, but for flat ones";

    const std::function<void(int)> boosting = [&](int features) { report("boosting", features); };
    LayerAttempt best = best_attempt({table, followed_, plan_[cascade_.stages.size()], cascade_.features, false_positive_rate_,
                                      config_.boost, config_.max_shift, threads_, boosting});
    if (best.stage.weak.empty()) return "no feature tells the objects from the rest";
    best.record.negatives = static_cast<int>(mined.windows.size());
    best.record.negatives_looked_at = mined.windows_looked_at;
    // (C-18)
    if (best.record.false_positive_rate > (1 - config_.min_improvement) * false_positive_rate_)
      return "a further layer of " + std::to_string(best.record.features) + " features does not help: false positive rate " +
             text(best.record.false_positive_rate) + " after it, " + text(false_positive_rate_) + " before";
    followed_.for_each([&](FollowedWindows& windows) { windows.pass(best.stage, best.features); });
    false_positive_rate_ = best.record.false_positive_rate;
    cascade_.provenance.layers.push_back(best.record);
    cascade_.features = std::move(best.features);
    cascade_.stages.push_back(std::move(best.stage));
    return "";
  }

  const CascadeTrainingData& data_;
  const TrainingPlan& plan_;
  const CascadeTrainerConfig& config_;
  int threads_;
  const TrainingProgressSink& progress_;
  Rng rng_;
  std::vector<HaarFeature> all_features_;
  FollowedSets followed_;
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
