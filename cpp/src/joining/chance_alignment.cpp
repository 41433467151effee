#include "ssjs/joining/chance_alignment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

/// Residuals of the pairs in the plane, their covariance, and how they follow the base of the observing map.
struct Residuals {
  Eigen::MatrixXd S;       ///< 2k x 2k
  Eigen::MatrixXd H_base;  ///< 2k x 3
  Eigen::Matrix3d P_base;
};

Residuals residuals_of(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted, const std::vector<Pair>& pairs,
                       const PortLevel& level) {
  std::vector<Sighting> own;
  std::vector<Sighting> others;
  for (const Pair& pair : pairs) {
    own.push_back(observed[static_cast<std::size_t>(pair.observation)]);
    others.push_back(predicted[static_cast<std::size_t>(pair.prediction)]);
  }
  std::vector<Unknown> unknowns = unknowns_of(own);
  const std::vector<Unknown> more = unknowns_of(others);
  unknowns.insert(unknowns.end(), more.begin(), more.end());
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  const PlacedSightings seen = place_sightings(own, unknowns, level.values());
  const PlacedSightings known = place_sightings(others, unknowns, level.values());
  Eigen::VectorXi plane(static_cast<Eigen::Index>(2 * pairs.size()));
  for (Eigen::Index i = 0; i < plane.size(); ++i) plane(i) = static_cast<int>(3 * (i / 2) + i % 2);
  const Eigen::MatrixXd J = (seen.J - known.J)(plane, Eigen::all);
  const Eigen::MatrixXd noise = (seen.noise + known.noise)(plane, plane);
  const Eigen::MatrixXd P = level.covariance(unknowns);
  const Unknown base{UnknownKind::kBase, own.front().map->base()};
  Eigen::Index column = 0;
  for (const Unknown& unknown : unknowns) {
    if (unknown == base) break;
    column += rows_of(unknown.kind);
  }
  // the covariance of residual and base together says how one follows the other, whatever else they have in common
  const Eigen::MatrixXd PJt = P * J.transpose();
  return {J * PJt + noise, PJt.middleRows<3>(column).transpose(), P.block<3, 3>(column, column)};
}

/// Landmarks that have any other within the gate, wherever the frame may be.
int within_reach(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted, const PortLevel& level, double gate) {
  const std::vector<Unknown> unknowns = unknowns_of(observed);
  const PlacedSightings seen = place_sightings(observed, unknowns, level.values());
  const PlacedSightings known = place_sightings(predicted, unknowns_of(predicted), level.values());
  const Eigen::MatrixXd P = level.covariance(unknowns);
  int count = 0;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(observed.size()); ++i) {
    const Eigen::MatrixXd J = seen.J.middleRows<2>(3 * i);
    const double reach_m = std::sqrt(gate) * largest_sigma(J * P * J.transpose() + seen.noise.block<2, 2>(3 * i, 3 * i));
    bool reached = false;
    for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(predicted.size()) && !reached; ++j) {
      reached = (known.mean.segment<2>(3 * j) - seen.mean.segment<2>(3 * i)).norm() <= reach_m;
    }
    count += reached ? 1 : 0;
  }
  return count;
}

}  // namespace

double binomial_tail(int n, double p, int k) {
  if (k <= 0) return 1.0;
  if (k > n || !(p > 0.0)) return 0.0;
  if (p >= 1.0) return 1.0;
  double sum = 0.0;
  for (int i = k; i <= n; ++i) {
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) + (n - i) * std::log1p(-p));
  }
  return std::min(sum, 1.0);
}

double expected_chance_alignments(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted,
                                  const std::vector<Pair>& pairs, const PortLevel& level, double density_per_m2, double gate_probability) {
  if (pairs.empty()) return 0.0;
  const double gate = chi_squared_quantile(gate_probability, 2.0);
  const Residuals r = residuals_of(observed, predicted, pairs, level);
  const Eigen::LLT<Eigen::MatrixXd> S(r.S);
  const Eigen::MatrixXd W = S.solve(Eigen::MatrixXd::Identity(r.S.rows(), r.S.cols()));
  double area_m2 = 0.0;  // in which a foreign landmark would have been taken, once the others say where the frame is
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(2 * i);
    area_m2 += kPi * gate / std::sqrt(W.block<2, 2>(at, at).determinant()) / static_cast<double>(pairs.size());
  }
  const Eigen::Matrix3d after = r.P_base - r.H_base.transpose() * S.solve(r.H_base);
  const double places = std::sqrt(r.P_base.determinant() / after.determinant());
  const double chance = 1.0 - std::exp(-density_per_m2 * area_m2);
  const int reached = std::max(within_reach(observed, predicted, level, gate), static_cast<int>(pairs.size()));
  return places * binomial_tail(reached, chance, static_cast<int>(pairs.size()));  // (W-5)
}

}  // namespace ssjs
