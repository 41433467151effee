#include "ssjs/association/compatibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::string shape(const Eigen::MatrixXd& matrix) { return std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()); }

void check_square(const char* argument, const Eigen::MatrixXd& matrix, Eigen::Index size) {
  if (matrix.rows() != size || matrix.cols() != size) {
    throw InvalidArgument(argument, shape(matrix),
                          "must be square, with a row for each of the " + std::to_string(size) + " stacked components");
  }
}

void check_shapes(const PairingProblem& problem) {
  const Eigen::Index m2 = problem.observed.size();
  const Eigen::Index n2 = problem.predicted.size();
  if (m2 % 2 != 0) throw InvalidArgument("observed", std::to_string(m2) + " components", "must stack two components per observation");
  if (n2 % 2 != 0) throw InvalidArgument("predicted", std::to_string(n2) + " components", "must stack two components per prediction");
  check_square("observed_covariance", problem.observed_covariance, m2);
  check_square("predicted_covariance", problem.predicted_covariance, n2);
  const Eigen::MatrixXd& C = problem.cross_covariance;
  if (C.size() != 0 && (C.rows() != n2 || C.cols() != m2)) {
    throw InvalidArgument("cross_covariance", shape(C), "must be 0 x 0 or " + std::to_string(n2) + " x " + std::to_string(m2));
  }
}

}  // namespace

Eigen::Vector2d pair_residual(const PairingProblem& problem, Eigen::Index observation, Eigen::Index prediction) {
  Eigen::Vector2d residual = problem.observed.segment<2>(2 * observation) - problem.predicted.segment<2>(2 * prediction);
  if (problem.second_component_is_angle) residual.y() = wrap_angle(residual.y());
  return residual;
}

Eigen::Matrix2d pair_covariance(const PairingProblem& problem, const Pair& ij, const Pair& kl) {
  Eigen::Matrix2d covariance = problem.observed_covariance.block<2, 2>(2 * ij.observation, 2 * kl.observation) +
                               problem.predicted_covariance.block<2, 2>(2 * ij.prediction, 2 * kl.prediction);
  if (problem.cross_covariance.size() != 0) {
    covariance -= problem.cross_covariance.block<2, 2>(2 * ij.prediction, 2 * kl.observation) +
                  problem.cross_covariance.block<2, 2>(2 * kl.prediction, 2 * ij.observation).transpose();
  }
  return covariance;
}

Compatibility individual_compatibility(const PairingProblem& problem, double gate) {
  check_shapes(problem);
  if (!(gate > 0.0)) throw InvalidArgument("gate", gate, "must be positive: a chi-squared quantile with 2 degrees of freedom");
  const Eigen::Index m = problem.observations();
  const Eigen::Index n = problem.predictions();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Compatibility result{Eigen::MatrixXd::Constant(m, n, kInfinity), std::vector<std::vector<Eigen::Index>>(static_cast<std::size_t>(m))};
  for (Eigen::Index i = 0; i < m; ++i) {
    double row_minimum = kInfinity;
    std::vector<Eigen::Index>& candidates = result.candidates[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < n; ++j) {
      // One component alone bounds the distance from below. A pair beyond the gate that cannot be the nearest either is
      // of no use to anybody: it stays at infinity.
      const double bound = std::max(gate, row_minimum);
      const Eigen::Matrix2d S = pair_covariance(problem, {i, j}, {i, j});
      const double first = problem.observed(2 * i) - problem.predicted(2 * j);
      if (S(0, 0) > 0.0 && first * first > bound * S(0, 0)) continue;
      const Eigen::Vector2d r = pair_residual(problem, i, j);
      if (S(1, 1) > 0.0 && r.y() * r.y() > bound * S(1, 1)) continue;
      const double determinant = S(0, 0) * S(1, 1) - S(0, 1) * S(1, 0);
      if (!(S(0, 0) > 0.0) || !(determinant > 0.0)) {
        throw NotPositiveDefinite("residual covariance", "observation " + std::to_string(i) + " with prediction " + std::to_string(j));
      }
      const double squared_distance =
          (S(1, 1) * r.x() * r.x() - (S(0, 1) + S(1, 0)) * r.x() * r.y() + S(0, 0) * r.y() * r.y()) / determinant;
      if (!std::isfinite(squared_distance)) {
        throw InvalidArgument("residual", squared_distance,
                              "observation " + std::to_string(i) + " with prediction " + std::to_string(j) + " must be finite");
      }
      result.squared_distance(i, j) = squared_distance;
      row_minimum = std::min(row_minimum, squared_distance);
      if (squared_distance <= gate) candidates.push_back(j);
    }
    std::sort(candidates.begin(), candidates.end(), [&](Eigen::Index a, Eigen::Index b) {
      const double distance_a = result.squared_distance(i, a);
      const double distance_b = result.squared_distance(i, b);
      return distance_a < distance_b || (distance_a == distance_b && a < b);
    });
  }
  return result;
}

std::vector<std::optional<double>> nearest_squared_distances(const Compatibility& compatibility) {
  const Eigen::MatrixXd& distance = compatibility.squared_distance;
  std::vector<std::optional<double>> nearest(static_cast<std::size_t>(distance.rows()));
  if (distance.cols() == 0) return nearest;
  for (Eigen::Index i = 0; i < distance.rows(); ++i) {
    const double minimum = distance.row(i).minCoeff();
    if (std::isfinite(minimum)) nearest[static_cast<std::size_t>(i)] = minimum;
  }
  return nearest;
}

}  // namespace ssjs
