/// All features on all cores, for the best of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/parallel_blocks.hpp"

namespace ssjs {

/// `examine(feature, scratch, best)` offers what it finds to `best`, a Found of its own for each block of features; `better(a, b)` is a
/// strict order, so that the result does not depend on `threads`. One feature in 61 is looked at before the others, which are measured by
/// what was found there; `between` is called after that.
template <class Found, class Examine, class Better, class Between>
Found sweep_features(std::size_t features, int threads, const Examine& examine, const Better& better, const Between& between) {
  constexpr std::size_t kFeaturesPerBlock = 256;
  constexpr std::size_t kScoutStride = 61;
  Found best;
  const auto pass = [&](const std::vector<std::size_t>& chosen) {
    const std::size_t blocks = (chosen.size() + kFeaturesPerBlock - 1) / kFeaturesPerBlock;
    std::vector<Found> best_of_block(blocks);
    parallel_blocks(blocks, threads, [&](std::size_t block) {
      FeatureTable::Scratch scratch;
      const std::size_t end = std::min(chosen.size(), (block + 1) * kFeaturesPerBlock);
      for (std::size_t k = block * kFeaturesPerBlock; k < end; ++k) examine(chosen[k], scratch, best_of_block[block]);
    });
    for (const Found& found : best_of_block)
      if (better(found, best)) best = found;
  };
  std::vector<std::size_t> scouts;
  std::vector<std::size_t> others;
  for (std::size_t f = 0; f < features; ++f) (f % kScoutStride == 0 ? scouts : others).push_back(f);
  pass(scouts);
  between();
  pass(others);
  return best;
}

}  // namespace ssjs
