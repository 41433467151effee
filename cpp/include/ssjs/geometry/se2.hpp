/// Rigid motions of the plane. `a_T_b` takes coordinates in frame b to frame a. Thesis appendix A, docs/math/se2.md.
///
/// Every covariance of an Se2 that is stored, passed or written is of the ADDITIVE coordinates (x m, y m, heading rad) in
/// the parent frame (frame a of a_T_b). Invariant coordinates exist only inside the global level (invariant_frame()).
#pragma once

#include <Eigen/Core>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/archive.hpp"

namespace ssjs {

struct Se2 {
  double x = 0.0;        ///< m
  double y = 0.0;        ///< m
  double heading = 0.0;  ///< rad, in [-pi, pi); turns x towards y

  [[nodiscard]] static Se2 from_vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), wrap_angle(v.z())}; }
  [[nodiscard]] Eigen::Vector3d vector() const { return {x, y, heading}; }
  [[nodiscard]] Eigen::Vector2d translation() const { return {x, y}; }
  [[nodiscard]] Eigen::Matrix2d rotation() const;

  [[nodiscard]] Se2 inverse() const;
  /// a_T_b * b_T_c = a_T_c
  [[nodiscard]] Se2 operator*(const Se2& b_T_c) const;
  /// a_T_b * b_p = a_p
  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& b_p) const;

  void archive(Archive& a) {
    a("x", x);
    a("y", y);
    a("heading", heading);
  }
};

/// left - right in additive coordinates, the heading wrapped.
[[nodiscard]] Eigen::Vector3d additive_difference(const Se2& left, const Se2& right);

/// pose + step in additive coordinates, the heading wrapped.
[[nodiscard]] Se2 additive_step(const Se2& pose, const Eigen::Vector3d& step);

/// J1 = d(a*b)/da, (S-2). a, b as in operator*.
[[nodiscard]] Eigen::Matrix3d compose_jacobian_left(const Se2& a_T_b, const Se2& b_T_c);
/// J2 = d(a*b)/db, (S-3).
[[nodiscard]] Eigen::Matrix3d compose_jacobian_right(const Se2& a_T_b);
/// d(a^-1)/da, (S-4).
[[nodiscard]] Eigen::Matrix3d inverse_jacobian(const Se2& a_T_b);
/// d(a*p)/da, 2x3, (S-5). d(a*p)/dp is a.rotation().
[[nodiscard]] Eigen::Matrix<double, 2, 3> act_jacobian(const Se2& a_T_b, const Eigen::Vector2d& b_p);

/// tau = i^-1 * j: pose of frame j in frame i, with both Jacobians (S-6).
struct RelativePose {
  Se2 i_T_j;
  Eigen::Matrix3d J_i;
  Eigen::Matrix3d J_j;
};
[[nodiscard]] RelativePose relative_pose(const Se2& global_T_i, const Se2& global_T_j);

/// Exponential map of the twist (v_x, v_y, omega) and its inverse, (S-7).
[[nodiscard]] Se2 se2_exp(const Eigen::Vector3d& twist);
[[nodiscard]] Eigen::Vector3d se2_log(const Se2& pose);

/// M(X): additive error = M(X) * right-invariant error xi, where X_true = Exp(xi) * X to first order, (S-8).
[[nodiscard]] Eigen::Matrix3d invariant_frame(const Se2& pose);

}  // namespace ssjs
