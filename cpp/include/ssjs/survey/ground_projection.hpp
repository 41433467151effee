/// Where a frame lies on level ground, from the pose of the vehicle that took it. docs/math/optical.md (V-26)
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/base/pinhole_camera.hpp"
#include "ssjs/geometry/se3.hpp"
#include "ssjs/sensors/pinhole.hpp"

namespace ssjs {

/// Pixels (u, v, 1) of the corrected frame -> (x, y, 1) of the global frame on the plane z = ground_depth_m; none when the plane is not at
/// least a centimetre ahead of the camera. (V-26)
[[nodiscard]] std::optional<Eigen::Matrix3d> ground_H_frame(const Se3& global_T_vehicle, double ground_depth_m, const PinholeCamera& camera,
                                                            const CameraConfig& mount);

}  // namespace ssjs
