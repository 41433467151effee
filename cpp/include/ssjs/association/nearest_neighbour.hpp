/// Greedy nearest neighbour inside the individual gate, one to one. Thesis 4.2.2, docs/math/association.md.
#pragma once

#include "ssjs/association/hypothesis.hpp"

namespace ssjs {

/// Takes the globally nearest compatible pair first, removes both partners, and goes on. Ties: lower observation, then lower prediction.
[[nodiscard]] Hypothesis nearest_neighbour(const PairingProblem& problem, double gate_probability);

}  // namespace ssjs
