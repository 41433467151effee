/// The best decision stump over all features: exact, at the price of histograms. docs/math/cascade.md (C-8) to (C-11).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/cascade/feature_table.hpp"

namespace ssjs {

enum class BoostType {
  kGentle,   ///< regression on +-1 by weighted least squares; leaves are the means. [friedman2000]
  kDiscrete  ///< weighted error; leaves are plus and minus the stump's vote. [freund1997], [viola2004]
};
[[nodiscard]] std::string to_string(BoostType type);

/// value < threshold: left, otherwise right.
struct Stump {
  std::size_t feature = 0;
  float threshold = 0;
  float left = 0;
  float right = 0;
};

/// The stump that gains most over one leaf for all, equal to trying each feature at each gap between two of its values. Of
/// equal gains the feature of least number wins, then the least threshold. Weights (not negative, positives first, as in the table) count
/// in 2^-30ths of their sum, so that sums do not depend on order and the result not on the number of threads. None if no feature tells any
/// two windows apart.
[[nodiscard]] std::optional<Stump> best_stump(const FeatureTable& table, const std::vector<double>& weights, BoostType type, int threads);

}  // namespace ssjs
