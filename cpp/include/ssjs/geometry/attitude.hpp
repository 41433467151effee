/// Rotations by roll, pitch and heading. docs/math/side_scan.md (SS-1)
#pragma once

#include <Eigen/Core>

namespace ssjs {

/// Marine axes: the body's x forward, y starboard, z down, its parent's z down. A positive roll puts starboard down, a positive
/// pitch the nose up, a positive heading turns x towards y.
struct Attitude {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double heading_rad = 0.0;
};

/// parent_R_body = Rz(heading) Ry(pitch) Rx(roll).
[[nodiscard]] Eigen::Matrix3d rotation(const Attitude& attitude);

/// Its derivatives.
[[nodiscard]] Eigen::Matrix3d rotation_by_roll(const Attitude& attitude);
[[nodiscard]] Eigen::Matrix3d rotation_by_pitch(const Attitude& attitude);
[[nodiscard]] Eigen::Matrix3d rotation_by_heading(const Attitude& attitude);

}  // namespace ssjs
