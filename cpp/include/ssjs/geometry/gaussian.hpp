/// A mean and its covariance, which move together.
#pragma once

#include <Eigen/Core>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

using Matrix6d = Eigen::Matrix<double, 6, 6>;  ///< covariance of two poses

/// Covariance of the additive coordinates in the parent frame of the mean (se2.hpp).
struct GaussianSe2 {
  Se2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  [[nodiscard]] GaussianSe2 inverse() const;  ///< J P J', (S-4)

  void archive(Archive& a) {
    a("mean", mean);
    a("covariance", covariance);
  }
};

struct GaussianPoint2 {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// J2 P J2' of a rotation: the covariance of b_T_c seen from a. (S-3)
[[nodiscard]] Eigen::Matrix3d turned(const Eigen::Matrix2d& a_R_b, const Eigen::Matrix3d& P);

/// a_T_b * b_T_c for INDEPENDENT factors: J1 P1 J1' + J2 P2 J2', (S-9).
[[nodiscard]] GaussianSe2 compose_independent(const GaussianSe2& a_T_b, const GaussianSe2& b_T_c);

/// Standard deviation in the direction where it is largest; lower triangle read.
[[nodiscard]] double largest_sigma(const Eigen::Matrix2d& covariance);

/// Lower Cholesky factor L of the symmetric matrix S = L L' (lower triangle read). Throws NotPositiveDefinite naming the
/// matrix and the detail when a pivot is not positive (NaN included).
[[nodiscard]] Eigen::MatrixXd cholesky_lower(const Eigen::Ref<const Eigen::MatrixXd>& S, const char* matrix, const char* detail);

/// Copies the lower triangle of P to the upper one.
void mirror_lower(Eigen::Ref<Eigen::MatrixXd> P);

}  // namespace ssjs
