#include "ssjs/geometry/gaussian.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ssjs/base/error.hpp"

namespace ssjs {

GaussianSe2 GaussianSe2::inverse() const {
  const Eigen::Matrix3d J = inverse_jacobian(mean);
  return {mean.inverse(), J * covariance * J.transpose()};
}

GaussianSe2 compose_independent(const GaussianSe2& a_T_b, const GaussianSe2& b_T_c) {
  const Eigen::Matrix3d J1 = compose_jacobian_left(a_T_b.mean, b_T_c.mean);
  const Eigen::Matrix3d J2 = compose_jacobian_right(a_T_b.mean);
  return {a_T_b.mean * b_T_c.mean, J1 * a_T_b.covariance * J1.transpose() + J2 * b_T_c.covariance * J2.transpose()};  // (S-9)
}

Eigen::MatrixXd cholesky_lower(const Eigen::Ref<const Eigen::MatrixXd>& S, const char* matrix, const char* detail) {
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> factor(S);
  // Eigen's test lets NaN through: a NaN pivot compares false with everything.
  if (factor.info() != Eigen::Success || !(factor.matrixLLT().diagonal().array() > 0.0).all()) {
    throw NotPositiveDefinite(matrix, detail);
  }
  return factor.matrixL();
}

void mirror_lower(Eigen::Ref<Eigen::MatrixXd> P) {
  constexpr Eigen::Index kTile = 32;  // tile by tile for the sake of the cache
  for (Eigen::Index column = 0; column < P.cols(); column += kTile) {
    const Eigen::Index columns = std::min(kTile, P.cols() - column);
    auto diagonal = P.block(column, column, columns, columns);
    diagonal.triangularView<Eigen::StrictlyUpper>() = diagonal.transpose();
    for (Eigen::Index row = column + kTile; row < P.rows(); row += kTile) {
      const Eigen::Index rows = std::min(kTile, P.rows() - row);
      P.block(column, row, columns, rows) = P.block(row, column, rows, columns).transpose();
    }
  }
}

}  // namespace ssjs
