/// Whether pairs that lay one map over another could as well be found where nothing is in common. docs/math/season.md (W-5).
#pragma once

#include <Eigen/Core>

namespace ssjs {

/// How many alignments with as many pairs are to be expected among foreign landmarks, over all the displacements that were open before the
/// pairing. Far below 1 the pairs mean something. 0 without pairs. S (2k x 2k): covariance of the residuals of the k pairs in the plane,
/// before the pairing, m². `landmarks`: those that might have found a partner, at least k. density_per_m2: of foreign landmarks that
/// would have been taken. gate: squared distance up to which one would have been. Throws NumericalError when S is none.
[[nodiscard]] double expected_chance_alignments(const Eigen::MatrixXd& S, int landmarks, double density_per_m2, double gate);

/// P(X >= k) of a binomial X with n trials of probability p.
[[nodiscard]] double binomial_tail(int n, double p, int k);

}  // namespace ssjs
