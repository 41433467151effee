/// What may stand as the covariance of a measurement that comes from outside.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace ssjs {

/// Standard deviations outside are those of no sensor, in metres and in radians alike: their squares and the inverses of those would use up
/// the digits or the range of a double.
inline constexpr double kLeastNoiseSigma = 1e-9, kLargestNoiseSigma = 1e6;

/// R, n x n in m^2, rad^2 and their mixtures, is finite, symmetric to 1e-9 of its largest entry, and positive definite; each standard
/// deviation is at most kLargestNoiseSigma, and at least kLeastNoiseSigma once the entries before it are known (the diagonal of its
/// Cholesky factor). Of anything else the filter would make a state that is known better than perfectly, and the survey an information
/// matrix that is not finite.
template <class Matrix>
[[nodiscard]] bool is_measurement_noise(const Matrix& R) {
  if (!R.allFinite()) return false;
  const double largest = R.cwiseAbs().maxCoeff();
  if (largest > kLargestNoiseSigma * kLargestNoiseSigma || (R - R.transpose()).cwiseAbs().maxCoeff() > 1e-9 * largest) return false;
  const Eigen::LLT<Matrix> factor(R);
  return factor.info() == Eigen::Success && factor.matrixLLT().diagonal().minCoeff() >= kLeastNoiseSigma;
}

}  // namespace ssjs
