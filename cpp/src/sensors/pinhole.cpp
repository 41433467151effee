#include "ssjs/sensors/pinhole.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

constexpr double kLeastDepth_m = 0.01;

/// d m / d(azimuth, elevation).
Eigen::Matrix<double, 3, 2> ray_jacobian(double a, double b) {
  Eigen::Matrix<double, 3, 2> J;
  J << std::cos(b) * std::cos(a), -std::sin(b) * std::sin(a),  //
      0.0, -std::cos(b),                                       //
      -std::cos(b) * std::sin(a), -std::sin(b) * std::cos(a);
  return J;
}

/// The pixel of a direction in the camera frame, and its derivative. (I-1)
struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> J;
};

Projection project(const Eigen::Vector3d& p, const PinholeCamera& camera) {
  const double x = p.x() / p.z(), y = p.y() / p.z();
  Projection seen;
  seen.pixel << camera.focal_x_px * x + camera.centre_x_px, camera.focal_y_px * y + camera.centre_y_px;
  seen.J << camera.focal_x_px / p.z(), 0.0, -camera.focal_x_px * x / p.z(),  //
      0.0, camera.focal_y_px / p.z(), -camera.focal_y_px * y / p.z();
  return seen;
}

/// camera_p as a linear function of what moves it: of the pose (x, y, z, roll, pitch, yaw) and of the landmark.
template <int L>
PixelPrediction<L> prediction_of(const Eigen::Vector3d& camera_p, const Eigen::Matrix<double, 3, 6>& J_pose,
                                 const Eigen::Matrix<double, 3, L>& J_landmark, const PinholeCamera& camera) {
  const Projection seen = project(camera_p, camera);
  PixelPrediction<L> predicted;
  predicted.pixel = seen.pixel;
  predicted.H_vehicle.setZero();
  predicted.H_vehicle.template block<2, 6>(0, Layout::kPosition) = seen.J * J_pose;
  predicted.H_landmark = seen.J * J_landmark;
  return predicted;
}

}  // namespace

std::optional<PinholeCamera> pinhole_camera(const CameraConfig& config) {
  const std::pair<const char*, bool> parts[] = {{"width_px", config.width_px.has_value()}, {"height_px", config.height_px.has_value()},
                                                {"fx_px", config.fx_px.has_value()},       {"fy_px", config.fy_px.has_value()},
                                                {"cx_px", config.cx_px.has_value()},       {"cy_px", config.cy_px.has_value()}};
  if (std::none_of(std::begin(parts), std::end(parts), [](const auto& part) { return part.second; })) return std::nullopt;
  for (const auto& [name, given] : parts) {
    if (!given) throw InvalidArgument(std::string("camera.") + name, "missing", "must be given, as the rest of the camera is");
  }
  return PinholeCamera{*config.width_px, *config.height_px, *config.fx_px, *config.fy_px, *config.cx_px, *config.cy_px};
}

Se3 vehicle_T_camera(const CameraConfig& config) {
  return {{config.mount_forward_m, config.mount_starboard_m, config.mount_down_m},
          {config.mount_roll_rad, config.mount_pitch_rad, config.mount_yaw_rad}};
}

Eigen::Vector3d ray_direction(double azimuth_rad, double elevation_rad) {
  const double a = azimuth_rad, b = elevation_rad;
  return {std::cos(b) * std::sin(a), -std::sin(b), std::cos(b) * std::cos(a)};
}

ConvertedPoint to_point(const InverseDepth& ray) {
  const double rho = ray(5);
  if (!(rho > 0.0)) throw InvalidArgument("inverse depth", rho, "must be positive: the point is at infinity or behind the camera");
  const Eigen::Vector3d m = ray_direction(ray(3), ray(4));
  ConvertedPoint converted;
  converted.map_p_point = ray.head<3>() + m / rho;
  converted.J << Eigen::Matrix3d::Identity(), ray_jacobian(ray(3), ray(4)) / rho, -m / (rho * rho);
  return converted;
}

std::optional<PixelPrediction<3>> predict_pixel(const VehicleVector& state, const Eigen::Vector3d& map_p_point, const PinholeCamera& camera,
                                                const CameraConfig& config) {
  const Se3 mount = vehicle_T_camera(config);
  const Se3 pose = map_T_vehicle(state);
  const Eigen::Matrix3d camera_R_vehicle = mount.rotation().transpose();
  const Eigen::Matrix3d camera_R_map = camera_R_vehicle * pose.rotation().transpose();
  const Eigen::Vector3d camera_p = camera_R_map * (map_p_point - pose.translation) - camera_R_vehicle * mount.translation;
  if (!(camera_p.z() > kLeastDepth_m)) return std::nullopt;
  return prediction_of<3>(camera_p, camera_R_vehicle * inverse_act_jacobian(pose, map_p_point), camera_R_map, camera);  // (I-2)
}

std::optional<PixelPrediction<6>> predict_pixel(const VehicleVector& state, const InverseDepth& ray, const PinholeCamera& camera,
                                                const CameraConfig& config) {
  const Se3 mount = vehicle_T_camera(config);
  const Se3 pose = map_T_vehicle(state);
  const double rho = ray(5);
  const Eigen::Matrix3d vehicle_R_map = pose.rotation().transpose();
  const Eigen::Matrix3d camera_R_vehicle = mount.rotation().transpose();
  const Eigen::Vector3d base = ray.head<3>() - pose.translation;
  const Eigen::Vector3d map_g = rho * base + ray_direction(ray(3), ray(4));  // rho times what lies between vehicle and point
  const Eigen::Vector3d camera_g = camera_R_vehicle * (vehicle_R_map * map_g - rho * mount.translation);
  if (!(camera_g.z() > kLeastDepth_m * std::abs(rho) && camera_g.z() > 1e-6)) return std::nullopt;
  Eigen::Matrix<double, 3, 6> J_pose, J_ray;  // (I-4)
  J_pose << -rho * vehicle_R_map, inverse_rotate_jacobian(pose.rpy, map_g);
  J_ray << rho * vehicle_R_map, vehicle_R_map * ray_jacobian(ray(3), ray(4)), vehicle_R_map * base - mount.translation;
  return prediction_of<6>(camera_g, camera_R_vehicle * J_pose, camera_R_vehicle * J_ray, camera);
}

std::optional<NewRay> ray_from_pixel(const VehicleVector& state, const Eigen::Vector2d& pixel, const PinholeCamera& camera,
                                     const CameraConfig& config) {
  const Se3 mount = vehicle_T_camera(config);
  const Se3 pose = map_T_vehicle(state);
  const Eigen::Vector3d camera_g((pixel.x() - camera.centre_x_px) / camera.focal_x_px, (pixel.y() - camera.centre_y_px) / camera.focal_y_px,
                                 1.0);
  const Eigen::Vector3d vehicle_g = mount.rotation() * camera_g;
  const Eigen::Vector3d g = pose.rotation() * vehicle_g;
  const Eigen::Vector3d c1 = pose * mount.translation;
  const double height = state(Layout::kSeabed) - c1.z();
  if (!(height > kLeastDepth_m && g.z() > 1e-3 * g.norm())) return std::nullopt;

  const double flat = std::hypot(g.x(), g.z());
  const double square = g.squaredNorm();
  const double length = std::sqrt(square);
  NewRay made;
  made.ray << c1, std::atan2(g.x(), g.z()), std::atan2(-g.y(), flat), g.z() / (length * height);  // (I-5)

  // (I-6): of (azimuth, elevation, inverse depth) by g, then of g and c1 by the pose and the pixel
  Eigen::Matrix3d J_g;
  J_g << g.z() / (flat * flat), 0.0, -g.x() / (flat * flat),                                     //
      g.y() * g.x() / (square * flat), -flat / square, g.y() * g.z() / (square * flat),          //
      -g.x() * g.z() / (square * length * height), -g.y() * g.z() / (square * length * height),  //
      (square - g.z() * g.z()) / (square * length * height);
  const double by_height = -made.ray(5) / height;
  made.J_vehicle.setZero();
  made.J_vehicle.block<3, 6>(0, Layout::kPosition) = act_jacobian(pose, mount.translation);
  made.J_vehicle.block<3, 3>(3, Layout::kAttitude) = J_g * rotate_jacobian(pose.rpy, vehicle_g);
  made.J_vehicle.row(5) -= by_height * made.J_vehicle.row(2);
  made.J_vehicle(5, Layout::kSeabed) += by_height;

  Eigen::Matrix<double, 3, 2> camera_g_by_pixel = Eigen::Matrix<double, 3, 2>::Zero();
  camera_g_by_pixel(0, 0) = 1.0 / camera.focal_x_px;
  camera_g_by_pixel(1, 1) = 1.0 / camera.focal_y_px;
  const Eigen::Matrix<double, 3, 2> J_pixel = J_g * pose.rotation() * mount.rotation() * camera_g_by_pixel;
  made.noise.setZero();
  made.noise.bottomRightCorner<3, 3>() = config.sigma_px * config.sigma_px * J_pixel * J_pixel.transpose();
  made.noise(5, 5) += std::pow(config.relief * made.ray(5), 2);
  return made;
}

double linearity_index(const InverseDepth& ray, double inverse_depth_sigma, const Eigen::Vector3d& map_p_camera) {
  const Eigen::Vector3d first = to_point(ray).map_p_point - ray.head<3>();
  const Eigen::Vector3d now = ray.head<3>() + first - map_p_camera;
  const double sigma_m = inverse_depth_sigma / (ray(5) * ray(5));
  return 4.0 * sigma_m * std::abs(first.dot(now)) / (first.norm() * now.squaredNorm());  // (I-7)
}

}  // namespace ssjs
