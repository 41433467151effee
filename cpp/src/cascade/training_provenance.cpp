#include "ssjs/cascade/training_provenance.hpp"

#include <sstream>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string trained_otherwise(const std::string& key, const std::string& before, const std::string& now) {
  std::string what = "was trained with ";
  what.append(key).append(" = ").append(before).append(", not ").append(now);
  return what.append("; train as before, or without --resume");
}

std::string text(double number) {
  std::ostringstream out;
  out.precision(12);
  out << number;
  return out.str();
}

std::string digest_of(const WindowSet& windows) {
  std::ostringstream out;
  out << windows.size() << " " << std::hex << windows.digest();
  return out.str();
}

}  // namespace

std::vector<std::pair<std::string, std::string>> training_settings(const CascadeTrainingData& data, const TrainingPlan& plan,
                                                                   const CascadeTrainerConfig& config) {
  std::vector<std::pair<std::string, std::string>> settings = {
      {"feature_set", to_string(config.feature_set)},
      {"boost", to_string(config.boost)},
      {"negatives_per_layer", config.negatives_per_layer ? std::to_string(*config.negatives_per_layer) : "twice the objects"},
      {"mining_scale_factor", text(config.mining_scale_factor)},
      {"min_improvement", text(config.min_improvement)},
      {"max_asymmetry", text(config.max_asymmetry)},
      {"max_shift", text(config.max_shift)},
      {"rejecting_features", std::to_string(config.rejecting_features)},
      {"seed", std::to_string(config.seed)},
      {"negative_images", std::to_string(data.negative_images.count) + " " + data.negative_images_digest},
      {"positives", digest_of(data.positives)},
      {"validation_positives", digest_of(data.validation_positives)},
      {"negatives", digest_of(data.negatives)},
      {"validation_negatives", digest_of(data.validation_negatives)}};
  for (std::size_t k = 0; k < plan.size(); ++k)
    settings.emplace_back("layer " + std::to_string(k + 1), text(plan[k].detection_rate) + " " + text(plan[k].false_positive_rate) + " " +
                                                                std::to_string(plan[k].max_features));
  return settings;
}

void check_same_training(const HaarCascade& found, const HaarCascade& expected, const std::string& path) {
  const Provenance& before = found.provenance;
  const Provenance& now = expected.provenance;
  if (found.window != expected.window || before.trained_with != now.trained_with)
    throw FileError(path, 0, "was trained by " + before.trained_with + " or for another window; train anew, or without --resume");
  for (std::size_t i = 0; i < now.settings.size(); ++i) {
    const auto& [key, value] = now.settings[i];
    const bool known = i < before.settings.size() && before.settings[i].first == key;
    if (!known || before.settings[i].second != value)
      throw FileError(path, 0, trained_otherwise(key, known ? before.settings[i].second : "nothing", value));
  }
}

}  // namespace ssjs
