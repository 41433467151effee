/// Whether two maps share enough to be tied: the decision that the methods with loops have in common. docs/math/ssjs.md (Decision).
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "ssjs/joining/map_association.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/joining/map_placement.hpp"

namespace ssjs {

struct LoopRule {
  double threshold = 0.4;                   ///< of the newer submap's landmarks
  int min_pairs = 3;                        ///< and at least so many
  std::optional<int> max_submap_landmarks;  ///< a submap with more counts as one with so many
};

/// Pairs that a new submap has to have with another map.
[[nodiscard]] int needed_pairs(const LoopRule& rule, const LiveMap& fresh);

/// Pairs of landmarks of a and b, where b is placed by an estimate independent of both; nothing when there are fewer than `needed` or
/// the placement leaves them ambiguous. The attempt says why. Known identities are counted before the placement is asked for.
[[nodiscard]] std::optional<std::vector<Pair>> attempt_loop(const LiveMap& a, const LiveMap& b, const std::function<GaussianSe2()>& a_T_b,
                                                            int needed, MapAssociator& associator, LoopAttempt& attempt,
                                                            JoinReport& report);

/// Without known identities the chi-squared of what the pairs were used for has to lie below this quantile. Sets the attempt's reason.
[[nodiscard]] bool fits(LoopAttempt& attempt, const MapAssociator& associator, double probability);

}  // namespace ssjs
