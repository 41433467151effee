/// Joint compatibility branch and bound (JCBB). [neira2001], docs/math/association.md.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/hypothesis.hpp"

namespace ssjs {

struct JointCompatibilityConfig {
  double gate_probability = 0.99;        ///< individual gate, 2 degrees of freedom
  double joint_gate_probability = 0.95;  ///< joint gate, 2k degrees of freedom
  int node_budget = 1500;                ///< nodes of the search tree; when it is spent the best so far is returned and said so
};

/// Among all one-to-one sets of individually compatible pairs that pass the joint gate, the one with most pairs; among
/// equals the one with the smallest joint distance. The search is exact: the answer does not depend on any order, unless
/// the node budget ends it early (then it is the best set found, and budget_exhausted says so).
/// Depth first over the observations, fewest candidates first, nearest candidate first; a first pass that also gates every set on
/// the way (the search of [neira2001]) finds a good bound, so the answer is never worse than its. One node appends one 2x2 block row
/// to a Cholesky factor and conditions the remaining candidates on it, O(k) each; candidates and branches that
/// could not be part of a better answer are cut. For a single observation it equals the individual and the joint gate together.
/// Assumes Gaussian residuals about one linearisation point.
[[nodiscard]] Hypothesis joint_compatibility(const PairingProblem& problem, const JointCompatibilityConfig& config);

/// The same among a subset of the observations (ascending, distinct), whose compatibility is already known.
[[nodiscard]] Hypothesis joint_compatibility(const PairingProblem& problem, const Compatibility& compatibility,
                                             const std::vector<Eigen::Index>& observations, const JointCompatibilityConfig& config);

}  // namespace ssjs
