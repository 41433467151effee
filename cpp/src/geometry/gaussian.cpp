#include "ssjs/geometry/gaussian.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {

GaussianSe2 GaussianSe2::inverse() const {
  const Eigen::Matrix3d J = inverse_jacobian(mean);
  return {mean.inverse(), J * covariance * J.transpose()};
}

Eigen::Matrix3d turned(const Eigen::Matrix2d& a_R_b, const Eigen::Matrix3d& P) {
  Eigen::Matrix3d a_P;
  a_P.topLeftCorner<2, 2>() = a_R_b * P.topLeftCorner<2, 2>() * a_R_b.transpose();
  a_P.topRightCorner<2, 1>() = a_R_b * P.topRightCorner<2, 1>();
  a_P.bottomLeftCorner<1, 2>() = a_P.topRightCorner<2, 1>().transpose();
  a_P(2, 2) = P(2, 2);
  return a_P;
}

GaussianSe2 compose_independent(const GaussianSe2& a_T_b, const GaussianSe2& b_T_c) {
  const Eigen::Matrix2d R = a_T_b.mean.rotation();
  const Eigen::Vector2d a_p = R * b_T_c.mean.translation();
  GaussianSe2 a_T_c{{a_T_b.mean.x + a_p.x(), a_T_b.mean.y + a_p.y(), wrap_angle(a_T_b.mean.heading + b_T_c.mean.heading)},
                    a_T_b.covariance};
  Eigen::Matrix3d& P = a_T_c.covariance;  // (S-9); J1 differs from the identity in its last column alone
  const Eigen::Vector2d lever(-a_p.y(), a_p.x());
  P.topRows<2>() += lever * P.row(2);
  P.leftCols<2>() += P.col(2) * lever.transpose();
  P += turned(R, b_T_c.covariance);
  return a_T_c;
}

double largest_sigma(const Eigen::Matrix2d& covariance) {
  const double middle = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double eigenvalue = middle + std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(1, 0));
  return std::sqrt(std::max(0.0, eigenvalue));
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
