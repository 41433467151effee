/// Individual compatibility: which single pairs pass the gate. docs/math/association.md.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/association/hypothesis.hpp"

namespace ssjs {

/// r_ij, the second component wrapped where it is an angle.
[[nodiscard]] Eigen::Vector2d pair_residual(const PairingProblem& problem, Eigen::Index observation, Eigen::Index prediction);

/// Cov(r_ij, r_kl) of.
[[nodiscard]] Eigen::Matrix2d pair_covariance(const PairingProblem& problem, const Pair& ij, const Pair& kl);

struct Compatibility {
  Eigen::MatrixXd squared_distance;                   ///< m x n, individual Mahalanobis distance squared (A-2); infinity where left out
  std::vector<std::vector<Eigen::Index>> candidates;  ///< per observation, the predictions inside the gate, nearest first
};

/// gate = chi-squared quantile with 2 degrees of freedom. A pair is left out (infinite distance) when it is beyond the gate and not
/// the nearest of its observation. Throws InvalidArgument on shapes that do not fit or residuals that are not finite, and
/// NotPositiveDefinite when the covariance of an evaluated pair is not.
[[nodiscard]] Compatibility individual_compatibility(const PairingProblem& problem, double gate);

/// m-vector of the row minima of squared_distance; empty entries where a row has no finite value.
[[nodiscard]] std::vector<std::optional<double>> nearest_squared_distances(const Compatibility& compatibility);

}  // namespace ssjs
