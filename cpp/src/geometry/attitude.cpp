#include "ssjs/geometry/attitude.hpp"

#include <cmath>

namespace ssjs {
namespace {

/// Sines and cosines of the three angles; a derivative replaces (cos, sin) of its angle by (-sin, cos) and the 1 by 0.
struct Turn {
  double c, s, fixed;
  explicit Turn(double angle) : c(std::cos(angle)), s(std::sin(angle)), fixed(1) {}
  Turn(double c_, double s_, double fixed_) : c(c_), s(s_), fixed(fixed_) {}
  [[nodiscard]] Turn derivative() const { return {-s, c, 0}; }
  [[nodiscard]] Eigen::Matrix3d about_x() const { return (Eigen::Matrix3d() << fixed, 0, 0, 0, c, -s, 0, s, c).finished(); }
  [[nodiscard]] Eigen::Matrix3d about_y() const { return (Eigen::Matrix3d() << c, 0, s, 0, fixed, 0, -s, 0, c).finished(); }
  [[nodiscard]] Eigen::Matrix3d about_z() const { return (Eigen::Matrix3d() << c, -s, 0, s, c, 0, 0, 0, fixed).finished(); }
};

}  // namespace

// (SS-1)
Eigen::Matrix3d rotation(const Attitude& attitude) {
  return Turn(attitude.heading_rad).about_z() * Turn(attitude.pitch_rad).about_y() * Turn(attitude.roll_rad).about_x();
}

Eigen::Matrix3d rotation_by_roll(const Attitude& attitude) {
  return Turn(attitude.heading_rad).about_z() * Turn(attitude.pitch_rad).about_y() * Turn(attitude.roll_rad).derivative().about_x();
}

Eigen::Matrix3d rotation_by_pitch(const Attitude& attitude) {
  return Turn(attitude.heading_rad).about_z() * Turn(attitude.pitch_rad).derivative().about_y() * Turn(attitude.roll_rad).about_x();
}

Eigen::Matrix3d rotation_by_heading(const Attitude& attitude) {
  return Turn(attitude.heading_rad).derivative().about_z() * Turn(attitude.pitch_rad).about_y() * Turn(attitude.roll_rad).about_x();
}

}  // namespace ssjs
