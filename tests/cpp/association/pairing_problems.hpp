/// Small pairing problems for the association tests, and the slow but certain ways to solve them.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/hypothesis.hpp"
#include "ssjs/association/joint_factor.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs::pairing_problems {

/// Independent observations and predictions: every 2x2 block is variance * I.
inline PairingProblem independent(const Eigen::VectorXd& observed, const Eigen::VectorXd& predicted, double observed_variance,
                                  double predicted_variance) {
  PairingProblem problem;
  problem.observed = observed;
  problem.predicted = predicted;
  problem.observed_covariance = observed_variance * Eigen::MatrixXd::Identity(observed.size(), observed.size());
  problem.predicted_covariance = predicted_variance * Eigen::MatrixXd::Identity(predicted.size(), predicted.size());
  return problem;
}

/// m observations near n predictions, everything correlated with everything (a random full covariance), cross covariance on request.
inline PairingProblem random_problem(Rng& rng, Eigen::Index m, Eigen::Index n, bool with_cross_covariance) {
  const Eigen::Index size = 2 * (m + n);
  Eigen::MatrixXd A(size, size);
  for (Eigen::Index column = 0; column < size; ++column) {
    for (Eigen::Index row = 0; row < size; ++row) A(row, column) = rng.normal();
  }
  const Eigen::MatrixXd P_all = A * A.transpose() / static_cast<double>(size) + 0.05 * Eigen::MatrixXd::Identity(size, size);
  PairingProblem problem;
  problem.predicted_covariance = P_all.topLeftCorner(2 * n, 2 * n);
  problem.observed_covariance = P_all.bottomRightCorner(2 * m, 2 * m);
  if (with_cross_covariance) problem.cross_covariance = P_all.topRightCorner(2 * n, 2 * m);
  problem.predicted.resize(2 * n);
  for (Eigen::Index k = 0; k < 2 * n; ++k) problem.predicted(k) = rng.normal(1.5);
  problem.observed.resize(2 * m);
  for (Eigen::Index k = 0; k < 2 * m; ++k) problem.observed(k) = problem.predicted(k % (2 * n)) + rng.normal(1.2);
  return problem;
}

/// for all pairs at once, by a dense inverse.
inline double dense_squared_distance(const PairingProblem& problem, const std::vector<Pair>& pairs) {
  const Eigen::Index k = static_cast<Eigen::Index>(pairs.size());
  Eigen::VectorXd residual(2 * k);
  Eigen::MatrixXd covariance(2 * k, 2 * k);
  for (Eigen::Index a = 0; a < k; ++a) {
    const Pair& ij = pairs[static_cast<std::size_t>(a)];
    residual.segment<2>(2 * a) = pair_residual(problem, ij.observation, ij.prediction);
    for (Eigen::Index b = 0; b < k; ++b)
      covariance.block<2, 2>(2 * a, 2 * b) = pair_covariance(problem, ij, pairs[static_cast<std::size_t>(b)]);
  }
  return k == 0 ? 0.0 : residual.dot(covariance.inverse() * residual);
}

/// Tries every one-to-one set of individually compatible pairs. Only for small problems.
class Enumeration {
 public:
  Enumeration(const PairingProblem& problem, double gate, double joint_gate_probability)
      : problem_(problem),
        compatibility_(individual_compatibility(problem, gate)),
        joint_gates_(joint_gates(joint_gate_probability, problem.observations())) {
    extend(0);
  }

  std::vector<Pair> best;
  double best_squared_distance = 0.0;
  int sets = 0;

 private:
  void extend(Eigen::Index observation) {
    if (observation == problem_.observations()) {
      ++sets;
      if (pairs_.empty()) return;
      const double distance = dense_squared_distance(problem_, pairs_);
      if (distance > joint_gates_[pairs_.size() - 1]) return;
      if (pairs_.size() > best.size() || (pairs_.size() == best.size() && distance < best_squared_distance)) {
        best = pairs_;
        best_squared_distance = distance;
      }
      return;
    }
    extend(observation + 1);
    for (const Eigen::Index j : compatibility_.candidates[static_cast<std::size_t>(observation)]) {
      bool taken = false;
      for (const Pair& pair : pairs_) taken = taken || pair.prediction == j;
      if (taken) continue;
      pairs_.push_back({observation, j});
      extend(observation + 1);
      pairs_.pop_back();
    }
  }

  const PairingProblem& problem_;
  Compatibility compatibility_;
  std::vector<double> joint_gates_;
  std::vector<Pair> pairs_;
};

}  // namespace ssjs::pairing_problems
