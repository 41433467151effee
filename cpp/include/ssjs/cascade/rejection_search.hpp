/// The stump that rejects the most windows without object while nearly every object passes: what the first layers of a cascade are
/// asked for, where the error of boosting is not. docs/math/cascade.md (C-21).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ssjs/cascade/stump_search.hpp"

namespace ssjs {

/// Of the samples of `table` with `standing` (0 or 1, one a sample) at most `lost` positives fail the stump found, and no other
/// stump that loses so few of them lets fewer negatives pass. Of equal ones the feature of least number wins, then the stump that accepts
/// great values. Leaves are the means of +-1, each class weighing one half. None if no stump rejects a negative. The result does not
/// depend on `threads`.
[[nodiscard]] std::optional<Stump> best_rejection(const FeatureTable& table, const std::vector<unsigned char>& standing, std::size_t lost,
                                                  int threads);

}  // namespace ssjs
