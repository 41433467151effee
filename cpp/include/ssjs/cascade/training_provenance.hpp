/// What a training was done with, as its model tells: the reason why a training of other data or settings cannot be carried on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "ssjs/cascade/cascade_trainer.hpp"

namespace ssjs {

/// Settings and digests of the data by name. The number of threads and the memory are not among them: results do not depend on them.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> training_settings(const CascadeTrainingData& data, const TrainingPlan& plan,
                                                                                 const CascadeTrainerConfig& config);

/// Throws FileError with the first difference if `found`, read from `path`, is no earlier state of the training of `expected`.
void check_same_training(const HaarCascade& found, const HaarCascade& expected, const std::string& path);

}  // namespace ssjs
