/// The only place where angles wrap. Radians throughout; a wrapped angle lies in [-pi, pi).
#pragma once

#include <cmath>

namespace ssjs {

inline constexpr double kPi = 3.14159265358979323846;

/// The same direction in [-pi, pi). NaN and infinity give NaN.
[[nodiscard]] inline double wrap_angle(double angle) {
  if (angle >= -kPi && angle < kPi) return angle;
  const double turned = std::remainder(angle, 2.0 * kPi);  // exact, in [-pi, pi]
  return turned >= kPi ? -kPi : turned;
}

/// measured - predicted, wrapped: the residual of an angle.
[[nodiscard]] inline double angle_difference(double measured, double predicted) { return wrap_angle(measured - predicted); }

}  // namespace ssjs
