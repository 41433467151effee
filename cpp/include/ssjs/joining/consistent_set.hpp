/// The heaviest set of closures no two of which contradict each other: maximum-weight clique of the graph of what is consistent, found as
/// the maximum-weight independent set of the graph of contradictions, which is sparse. [mangelson2018], docs/math/closures.md (C-7, C-8).
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace ssjs {

struct ConsistentSet {
  std::vector<bool> kept;  ///< by closure
  double weight = 0.0;     ///< of the kept ones
  bool exact = true;       ///< false: the budget ran out somewhere, and what had been found by then stands
};

/// weights: > 0, one a closure. contradictions: pairs (a, b), a != b. Closures without contradictions are kept; each connected piece of the
/// others is searched by branch and bound with a budget of `node_budget` nodes of its own. Of sets of one weight the one found first
/// stands, which depends on the numbering alone. Throws InvalidArgument on an index out of range or a weight that is not positive.
[[nodiscard]] ConsistentSet heaviest_consistent_set(const std::vector<double>& weights,
                                                    const std::vector<std::pair<std::size_t, std::size_t>>& contradictions,
                                                    int node_budget);

}  // namespace ssjs
