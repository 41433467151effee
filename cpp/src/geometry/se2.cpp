#include "ssjs/geometry/se2.hpp"

#include <cmath>

namespace ssjs {

Eigen::Matrix2d Se2::rotation() const {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  Eigen::Matrix2d R;
  R << c, -s, s, c;
  return R;
}

Se2 Se2::inverse() const {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  return {-c * x - s * y, s * x - c * y, wrap_angle(-heading)};
}

Se2 Se2::operator*(const Se2& b_T_c) const {
  const Eigen::Vector2d a_p_c = *this * b_T_c.translation();
  return {a_p_c.x(), a_p_c.y(), wrap_angle(heading + b_T_c.heading)};
}

Eigen::Vector2d Se2::operator*(const Eigen::Vector2d& b_p) const {
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  return {x + c * b_p.x() - s * b_p.y(), y + s * b_p.x() + c * b_p.y()};
}

Eigen::Vector3d additive_difference(const Se2& left, const Se2& right) {
  return {left.x - right.x, left.y - right.y, angle_difference(left.heading, right.heading)};
}

Se2 additive_step(const Se2& pose, const Eigen::Vector3d& step) {
  return {pose.x + step.x(), pose.y + step.y(), wrap_angle(pose.heading + step.z())};
}

Eigen::Matrix3d compose_jacobian_left(const Se2& a_T_b, const Se2& b_T_c) {
  Eigen::Matrix3d J1 = Eigen::Matrix3d::Identity();  // (S-2)
  J1.topRows<2>() = act_jacobian(a_T_b, b_T_c.translation());
  return J1;
}

Eigen::Matrix3d compose_jacobian_right(const Se2& a_T_b) {
  Eigen::Matrix3d J2 = Eigen::Matrix3d::Identity();  // (S-3)
  J2.topLeftCorner<2, 2>() = a_T_b.rotation();
  return J2;
}

Eigen::Matrix3d inverse_jacobian(const Se2& a_T_b) {
  const double c = std::cos(a_T_b.heading);
  const double s = std::sin(a_T_b.heading);
  Eigen::Matrix3d J_inverse;                       // (S-4)
  J_inverse << -c, -s, s * a_T_b.x - c * a_T_b.y,  //
      s, -c, c * a_T_b.x + s * a_T_b.y,            //
      0.0, 0.0, -1.0;
  return J_inverse;
}

Eigen::Matrix<double, 2, 3> act_jacobian(const Se2& a_T_b, const Eigen::Vector2d& b_p) {
  const double c = std::cos(a_T_b.heading);
  const double s = std::sin(a_T_b.heading);
  Eigen::Matrix<double, 2, 3> J;              // (S-5)
  J << 1.0, 0.0, -s * b_p.x() - c * b_p.y(),  //
      0.0, 1.0, c * b_p.x() - s * b_p.y();
  return J;
}

RelativePose relative_pose(const Se2& global_T_i, const Se2& global_T_j) {
  const Se2 i_T_global = global_T_i.inverse();
  return {i_T_global * global_T_j,  // (S-6)
          compose_jacobian_left(i_T_global, global_T_j) * inverse_jacobian(global_T_i), compose_jacobian_right(i_T_global)};
}

Se2 se2_exp(const Eigen::Vector3d& twist) {
  const double w = twist.z();
  // sin(w)/w and (1-cos(w))/w by series near zero, where the quotients lose digits
  const bool small = std::abs(w) < 1e-4;
  const double a = small ? 1.0 - w * w / 6.0 : std::sin(w) / w;
  const double b = small ? 0.5 * w - w * w * w / 24.0 : (1.0 - std::cos(w)) / w;
  return {a * twist.x() - b * twist.y(), b * twist.x() + a * twist.y(), wrap_angle(w)};  // (S-7)
}

Eigen::Vector3d se2_log(const Se2& pose) {
  const double w = pose.heading;
  const double half = 0.5 * w;
  const double a = std::abs(w) < 1e-4 ? 1.0 - w * w / 12.0 : half / std::tan(half);
  return {a * pose.x + half * pose.y, -half * pose.x + a * pose.y, w};
}

Eigen::Matrix3d invariant_frame(const Se2& pose) {
  Eigen::Matrix3d M;       // (S-8)
  M << 1.0, 0.0, -pose.y,  //
      0.0, 1.0, pose.x,    //
      0.0, 0.0, 1.0;
  return M;
}

}  // namespace ssjs
