/// The question and the answer of data association, the same for a scan against a map and for a map against a map.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ssjs {

/// m observations and n predictions of two components each, stacked, with their joint covariance:
///   residual r_ij = observed_i - predicted_j,
///   Cov(r_ij, r_kl) = O(i,k) + P(j,l) - C(j,k) - C(l,i)'         
/// with O = observed_covariance (2m x 2m), P = predicted_covariance (2n x 2n), C = cross_covariance of (predicted, observed)
/// (2n x 2m; 0 x 0 means zero). A scan has range and bearing (second component an angle), a map pair has x and y.
struct PairingProblem {
  Eigen::VectorXd observed;
  Eigen::VectorXd predicted;
  Eigen::MatrixXd observed_covariance;
  Eigen::MatrixXd predicted_covariance;
  Eigen::MatrixXd cross_covariance;
  bool second_component_is_angle = false;

  [[nodiscard]] Eigen::Index observations() const { return observed.size() / 2; }
  [[nodiscard]] Eigen::Index predictions() const { return predicted.size() / 2; }
};

/// observation i is paired with prediction j, each at most once.
struct Pair {
  Eigen::Index observation;
  Eigen::Index prediction;
};

/// By observation, then by prediction.
[[nodiscard]] inline bool operator<(const Pair& a, const Pair& b) {
  return a.observation != b.observation ? a.observation < b.observation : a.prediction < b.prediction;
}
[[nodiscard]] inline bool operator==(const Pair& a, const Pair& b) {
  return a.observation == b.observation && a.prediction == b.prediction;
}

struct Hypothesis {
  std::vector<Pair> pairs;  ///< ascending observation
  /// For every observation the smallest individual Mahalanobis distance squared to any prediction; empty when there is none.
  std::vector<std::optional<double>> nearest_squared_distance;
  double joint_squared_distance = 0.0;  ///< of all pairs together, 2 * pairs.size() degrees of freedom
  int nodes_visited = 0;                ///< of the search tree; 0 where there is none
  bool budget_exhausted = false;        ///< the best hypothesis found within the budget was returned
};

}  // namespace ssjs
