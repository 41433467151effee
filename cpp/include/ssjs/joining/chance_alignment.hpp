/// Whether pairs that lay one map over another could as well be found where nothing is in common. docs/math/season.md (W-5).
#pragma once

#include <utility>
#include <vector>

#include "ssjs/joining/port_association.hpp"

namespace ssjs {

/// Landmarks of one map (`observed`, all of them that are no ports yet) with those of others, as associate_sightings() paired them.
/// The answer: how many alignments with as many pairs are to be expected among foreign landmarks of this density, over all the places
/// where the frame of the map might be. Far below 1 the pairs mean something. 0 without pairs.
[[nodiscard]] double expected_chance_alignments(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted,
                                                const std::vector<Pair>& pairs, const PortLevel& level, double density_per_m2,
                                                double gate_probability);

/// P(X >= k) of a binomial X with n trials of probability p.
[[nodiscard]] double binomial_tail(int n, double p, int k);

}  // namespace ssjs
