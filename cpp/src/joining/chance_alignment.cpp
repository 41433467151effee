#include "ssjs/joining/chance_alignment.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

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

double expected_chance_alignments(const Eigen::MatrixXd& S, int landmarks, double density_per_m2, double gate) {
  if (S.rows() == 0) return 0.0;
  const auto pairs = static_cast<int>(S.rows() / 2);
  const Eigen::MatrixXd L = cholesky_lower(S, "residual covariance", "pairs of two maps");
  const Eigen::MatrixXd L_inverse = L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(S.rows(), S.rows()));
  const Eigen::MatrixXd W = L_inverse.transpose() * L_inverse;
  double log_places = L.diagonal().array().log().sum();  // of the square root of the determinant of S
  double area_m2 = 0.0;                                  // in which a foreign landmark would have been taken, the others given
  for (int i = 0; i < pairs; ++i) {
    const double root = 1.0 / std::sqrt(W.block<2, 2>(2 * i, 2 * i).determinant());  // sqrt |S_i|, given the others
    log_places -= std::log(root);
    area_m2 += kPi * gate * root / pairs;
  }
  const double chance = 1.0 - std::exp(-density_per_m2 * area_m2);
  return std::exp(log_places) * binomial_tail(std::max(landmarks, pairs), chance, pairs);  // (W-5)
}

}  // namespace ssjs
