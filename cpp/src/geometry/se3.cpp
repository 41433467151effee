#include "ssjs/geometry/se3.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kDegrees = 180.0 / kPi;

void refuse_vertical(double cos_pitch, double pitch) {
  if (std::abs(cos_pitch) >= kMinCosPitch) return;
  throw InvalidArgument("pitch in degrees", pitch * kDegrees,
                        "must stay away from +-90: there roll and yaw are the same turn, and their rates have no bound");
}

struct AxisRotations {
  Eigen::Matrix3d z, y, x;
};

AxisRotations axis_rotations(const Eigen::Vector3d& rpy) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  const double cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  AxisRotations R;
  R.z << cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0;
  R.y << cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp;
  R.x << 1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr;
  return R;
}

/// sin(t)/t, (1-cos(t))/t^2 and (t-sin(t))/t^3; by series where the quotients lose digits.
struct ExpTerms {
  double a, b, c;
};

ExpTerms exp_terms(double t) {
  const double t2 = t * t;
  if (t < 1e-2) {
    return {1.0 - t2 / 6.0 * (1.0 - t2 / 20.0), 0.5 - t2 / 24.0 * (1.0 - t2 / 30.0), 1.0 / 6.0 - t2 / 120.0 * (1.0 - t2 / 42.0)};
  }
  return {std::sin(t) / t, (1.0 - std::cos(t)) / t2, (t - std::sin(t)) / (t2 * t)};
}

Eigen::Matrix3d translation_of_twist(const Eigen::Vector3d& omega) {
  const ExpTerms terms = exp_terms(omega.norm());
  const Eigen::Matrix3d W = skew(omega);
  return Eigen::Matrix3d::Identity() + terms.b * W + terms.c * W * W;
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d axis_times_2_sin(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sine = 0.5 * axis_times_2_sin.norm();
  const double cosine = 0.5 * (R.trace() - 1.0);
  const double angle = std::atan2(sine, cosine);
  if (cosine > -0.9) return axis_times_2_sin * (0.5 / exp_terms(angle).a);
  // next to half a turn the axis is in the symmetric part: (R + R')/2 = cos I + (1 - cos) n n'
  const Eigen::Matrix3d nn = (0.5 * (R + R.transpose()) - cosine * Eigen::Matrix3d::Identity()) / (1.0 - cosine);
  Eigen::Index column = 0;
  nn.diagonal().maxCoeff(&column);
  const Eigen::Vector3d axis = nn.col(column) / std::sqrt(nn(column, column));
  return (axis.dot(axis_times_2_sin) < 0.0 ? -angle : angle) * axis;
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy) {
  const AxisRotations R = axis_rotations(rpy);
  return R.z * R.y * R.x;
}

Eigen::Vector3d rpy_from_rotation(const Eigen::Matrix3d& R) {
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  const double pitch = std::atan2(-R(2, 0), cos_pitch);
  refuse_vertical(cos_pitch, pitch);
  return {wrap_angle(std::atan2(R(2, 1), R(2, 2))), pitch, wrap_angle(std::atan2(R(1, 0), R(0, 0)))};
}

Eigen::Matrix3d rotate_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& v) {
  const AxisRotations R = axis_rotations(rpy);
  const Eigen::Vector3d rolled = R.x * v;
  const Eigen::Vector3d pitched = R.y * rolled;
  Eigen::Matrix3d J;
  J << R.z * R.y * skew(Eigen::Vector3d::UnitX()) * rolled, R.z * skew(Eigen::Vector3d::UnitY()) * pitched,
      skew(Eigen::Vector3d::UnitZ()) * R.z * pitched;
  return J;
}

Eigen::Matrix3d inverse_rotate_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& v) {
  const AxisRotations R = axis_rotations(rpy);
  const Eigen::Vector3d unyawed = R.z.transpose() * v;
  const Eigen::Vector3d unpitched = R.y.transpose() * unyawed;
  Eigen::Matrix3d J;
  J << -skew(Eigen::Vector3d::UnitX()) * R.x.transpose() * unpitched, -R.x.transpose() * skew(Eigen::Vector3d::UnitY()) * unpitched,
      -R.x.transpose() * R.y.transpose() * skew(Eigen::Vector3d::UnitZ()) * unyawed;
  return J;
}

Eigen::Matrix3d euler_rate_matrix(const Eigen::Vector3d& rpy) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  Eigen::Matrix3d E;
  E << 1.0, 0.0, -sp, 0.0, cr, sr * cp, 0.0, -sr, cr * cp;
  return E;
}

Eigen::Matrix3d inverse_euler_rate_matrix(const Eigen::Vector3d& rpy) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  refuse_vertical(cp, rpy.y());
  Eigen::Matrix3d E_inverse;
  E_inverse << 1.0, sr * sp / cp, cr * sp / cp, 0.0, cr, -sr, 0.0, sr / cp, cr / cp;
  return E_inverse;
}

Eigen::Matrix3d euler_rates_jacobian(const Eigen::Vector3d& rpy, const Eigen::Vector3d& body_rates_rad_s) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  refuse_vertical(cp, rpy.y());
  const double q = body_rates_rad_s.y(), r = body_rates_rad_s.z();
  const double along = sr * q + cr * r;   // yaw rate times cos(pitch)
  const double across = cr * q - sr * r;  // pitch rate
  Eigen::Matrix3d J;
  J << across * sp / cp, along / (cp * cp), 0.0, -along, 0.0, 0.0, across / cp, along * sp / (cp * cp), 0.0;
  return J;
}

Se3 Se3::inverse() const {
  const Eigen::Matrix3d b_R_a = rotation().transpose();
  return {-b_R_a * translation, rpy_from_rotation(b_R_a)};
}

Se3 Se3::operator*(const Se3& b_T_c) const {
  const Eigen::Matrix3d a_R_b = rotation();
  return {translation + a_R_b * b_T_c.translation, rpy_from_rotation(a_R_b * b_T_c.rotation())};
}

Vector6d additive_difference(const Se3& left, const Se3& right) {
  Vector6d difference = left.vector() - right.vector();
  for (Eigen::Index i = 3; i < 6; ++i) difference(i) = wrap_angle(difference(i));
  return difference;
}

Matrix6d compose_jacobian_left(const Se3& a_T_b, const Se3& b_T_c) {
  const Eigen::Matrix3d b_R_c = b_T_c.rotation();
  const Eigen::Vector3d rpy = rpy_from_rotation(a_T_b.rotation() * b_R_c);
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = rotate_jacobian(a_T_b.rpy, b_T_c.translation);
  J.bottomRightCorner<3, 3>() = inverse_euler_rate_matrix(rpy) * b_R_c.transpose() * euler_rate_matrix(a_T_b.rpy);
  return J;
}

Matrix6d compose_jacobian_right(const Se3& a_T_b, const Se3& b_T_c) {
  const Eigen::Matrix3d a_R_b = a_T_b.rotation();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = a_R_b;
  J.bottomRightCorner<3, 3>() = inverse_euler_rate_matrix(rpy_from_rotation(a_R_b * b_T_c.rotation())) * euler_rate_matrix(b_T_c.rpy);
  return J;
}

Matrix6d inverse_jacobian(const Se3& a_T_b) {
  const Eigen::Matrix3d R = a_T_b.rotation();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = -R.transpose();
  J.topRightCorner<3, 3>() = -inverse_rotate_jacobian(a_T_b.rpy, a_T_b.translation);
  J.bottomRightCorner<3, 3>() = -inverse_euler_rate_matrix(rpy_from_rotation(R.transpose())) * R * euler_rate_matrix(a_T_b.rpy);
  return J;
}

Eigen::Matrix<double, 3, 6> act_jacobian(const Se3& a_T_b, const Eigen::Vector3d& b_p) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), rotate_jacobian(a_T_b.rpy, b_p);
  return J;
}

Eigen::Matrix<double, 3, 6> inverse_act_jacobian(const Se3& a_T_b, const Eigen::Vector3d& a_p) {
  Eigen::Matrix<double, 3, 6> J;
  J << -a_T_b.rotation().transpose(), inverse_rotate_jacobian(a_T_b.rpy, a_p - a_T_b.translation);
  return J;
}

Se3 se3_exp(const Vector6d& twist) {
  const Eigen::Vector3d omega = twist.tail<3>();
  const ExpTerms terms = exp_terms(omega.norm());
  const Eigen::Matrix3d W = skew(omega);
  const Eigen::Matrix3d R = Eigen::Matrix3d::Identity() + terms.a * W + terms.b * W * W;
  return {translation_of_twist(omega) * twist.head<3>(), rpy_from_rotation(R)};
}

Vector6d se3_log(const Se3& pose) {
  const Eigen::Vector3d omega = rotation_vector(pose.rotation());
  Vector6d twist;
  twist << translation_of_twist(omega).partialPivLu().solve(pose.translation), omega;
  return twist;
}

Matrix6d adjoint(const Se3& pose) {
  const Eigen::Matrix3d R = pose.rotation();
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = R;
  Ad.topRightCorner<3, 3>() = skew(pose.translation) * R;
  Ad.bottomRightCorner<3, 3>() = R;
  return Ad;
}

}  // namespace ssjs
