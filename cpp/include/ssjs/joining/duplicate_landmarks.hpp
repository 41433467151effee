/// A landmark that stands in one map twice: entered anew where it could not be recognised, and told apart from the older copy no longer.
/// docs/math/joining_methods.md (L-5).
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/map_association.hpp"

namespace ssjs {

struct Duplicates {
  std::vector<Pair> pairs;  ///< observation = one of the recent landmarks, prediction = an older copy
  bool budget_exhausted = false;
};

/// Associates the map with itself: `recent` landmarks (ascending, one sight of the world, so different from each other) with all others in
/// reach. Left out are pairs that are `distinct` on other grounds, and those whose relative position is too unsure.
[[nodiscard]] Duplicates find_duplicates(const LiveMap& map, const std::vector<Eigen::Index>& recent,
                                         const std::function<bool(Eigen::Index, Eigen::Index)>& distinct, MapAssociator& associator);

/// Constrains the landmarks of each pair to be equal and drops the one that stands later in the map. No port may be declared.
/// Returns the chi-squared of the constraints, 2 degrees of freedom a pair.
double merge_duplicates(LiveMap& map, const std::vector<Pair>& pairs);

}  // namespace ssjs
