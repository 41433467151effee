#include "ssjs/survey/ground_projection.hpp"

#include <Eigen/LU>

namespace ssjs {

std::optional<Eigen::Matrix3d> ground_H_frame(const Se3& global_T_vehicle, double ground_depth_m, const PinholeCamera& camera,
                                              const CameraConfig& mount) {
  constexpr double kLeastHeight = 0.01;
  const Se3 global_T_camera = global_T_vehicle * vehicle_T_camera(mount);
  const Se3 camera_T_global = global_T_camera.inverse();
  if (!(ground_depth_m - global_T_camera.translation.z() > kLeastHeight)) return std::nullopt;
  const Eigen::Matrix3d R = camera_T_global.rotation();
  Eigen::Matrix3d K, plane;  // plane: (x, y, 1) on the ground -> camera frame
  K << camera.focal_x_px, 0.0, camera.centre_x_px, 0.0, camera.focal_y_px, camera.centre_y_px, 0.0, 0.0, 1.0;
  plane << R.leftCols<2>(), R.col(2) * ground_depth_m + camera_T_global.translation;
  const Eigen::Matrix3d H = (K * plane).inverse();  // (V-26)
  if (!H.allFinite() || H(2, 2) == 0.0) return std::nullopt;
  return H / H(2, 2);
}

}  // namespace ssjs
