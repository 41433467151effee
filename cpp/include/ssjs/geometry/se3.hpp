/// Rigid motions of space. `a_T_b` takes coordinates in frame b to frame a. Thesis A.3-A.6 corrected; docs/math/se3.md (R-1..R-10).
///
/// Every covariance of an Se3 is of the ADDITIVE coordinates (x, y, z m, roll, pitch, yaw rad) in the parent frame. Roll, pitch and yaw
/// are those of a_R_b = Rz(yaw) Ry(pitch) Rx(roll): x forward, y starboard, z down. At a pitch of +-90 degrees roll and yaw are one angle:
/// what needs them apart throws InvalidArgument there.
#pragma once

#include <Eigen/Core>

#include "ssjs/base/angle.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// cos(pitch) below this is too near +-90 degrees (about 0.06 degrees of it).
inline constexpr double kMinCosPitch = 1e-3;

[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);  ///< skew(v) w = v x w

[[nodiscard]] Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy);  ///< (R-1)
/// Its inverse, pitch in (-pi/2, pi/2), roll and yaw in [-pi, pi).
[[nodiscard]] Eigen::Vector3d rpy_from_rotation(const Eigen::Matrix3d& R);

[[nodiscard]] Eigen::Matrix3d rotate_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& v);          ///< d(R v)/d rpy, (R-3)
[[nodiscard]] Eigen::Matrix3d inverse_rotate_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& v);  ///< d(R' v)/d rpy, (R-3)

/// E: body rates (rad/s, about the body axes) = E * rates of (roll, pitch, yaw).
[[nodiscard]] Eigen::Matrix3d euler_rate_matrix(const Eigen::Vector3d& rpy);
[[nodiscard]] Eigen::Matrix3d inverse_euler_rate_matrix(const Eigen::Vector3d& rpy);  ///< E^-1; throws near +-90 degrees of pitch
/// d(E^-1 w)/d rpy.
[[nodiscard]] Eigen::Matrix3d euler_rates_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& body_rates_rad_s);

struct Se3 {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();          ///< rad, each in [-pi, pi)

  [[nodiscard]] static Se3 from_vector(const Vector6d& v) { return {v.head<3>(), {wrap_angle(v(3)), wrap_angle(v(4)), wrap_angle(v(5))}}; }
  [[nodiscard]] Vector6d vector() const { return (Vector6d() << translation, rpy).finished(); }
  [[nodiscard]] Eigen::Matrix3d rotation() const { return rotation_from_rpy(rpy); }

  [[nodiscard]] Se3 inverse() const;
  /// a_T_b * b_T_c = a_T_c
  [[nodiscard]] Se3 operator*(const Se3& b_T_c) const;
  /// a_T_b * b_p = a_p
  [[nodiscard]] Eigen::Vector3d operator*(const Eigen::Vector3d& b_p) const { return translation + rotation() * b_p; }
};

/// left - right in additive coordinates, the angles wrapped.
[[nodiscard]] Vector6d additive_difference(const Se3& left, const Se3& right);

[[nodiscard]] Matrix6d compose_jacobian_left(const Se3& a_T_b, const Se3& b_T_c);   ///< d(a*b)/da, (R-6)
[[nodiscard]] Matrix6d compose_jacobian_right(const Se3& a_T_b, const Se3& b_T_c);  ///< d(a*b)/db, (R-6)
[[nodiscard]] Matrix6d inverse_jacobian(const Se3& a_T_b);                          ///< d(a^-1)/da, (R-7)
/// d(a*p)/da, (R-8). d(a*p)/dp is a.rotation().
[[nodiscard]] Eigen::Matrix<double, 3, 6> act_jacobian(const Se3& a_T_b, const Eigen::Vector3d& b_p);
/// d(a^-1*p)/da, (R-8). d(a^-1*p)/dp is a.rotation()'.
[[nodiscard]] Eigen::Matrix<double, 3, 6> inverse_act_jacobian(const Se3& a_T_b, const Eigen::Vector3d& a_p);

/// Exponential map of the twist (v, omega), both 3, and its inverse; rotations below pi.
[[nodiscard]] Se3 se3_exp(const Vector6d& twist);
[[nodiscard]] Vector6d se3_log(const Se3& pose);
/// T Exp(xi) T^-1 = Exp(Ad(T) xi), twists as in se3_exp.
[[nodiscard]] Matrix6d adjoint(const Se3& pose);

}  // namespace ssjs
