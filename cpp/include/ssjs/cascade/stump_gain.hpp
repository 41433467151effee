/// What a split gains, and what no split of a histogram can exceed. docs/math/cascade.md (C-8), (C-10).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/stump_search.hpp"

namespace ssjs {

/// Weights of the positives and of the negatives, in 2^-30ths of all.
struct Mass {
  std::uint32_t positive = 0;
  std::uint32_t negative = 0;
};
constexpr double kWholeMass = 1U << 30U;
[[nodiscard]] inline double total(Mass mass) { return static_cast<double>(mass.positive) + mass.negative; }

/// (C-8): what a split gains when `left` of `all` goes left.
[[nodiscard]] double split_gain(BoostType type, Mass left, Mass all);

/// Negative and positive mass of each bin in turn.
using MassHistogram = std::array<std::uint32_t, 2 * FeatureTable::kBins>;

/// (C-10): no split of the samples counted gains more, wherever in a bin it falls. `all`: their mass.
[[nodiscard]] double gain_bound(BoostType type, const MassHistogram& histogram, Mass all);

}  // namespace ssjs
