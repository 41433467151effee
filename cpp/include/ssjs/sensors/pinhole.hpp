/// Points seen by a camera: pixels against points of the map, and points in inverse depth, which a single frame can start.
/// Thesis 5.16-5.24 corrected, [civera2008]; docs/math/camera.md (I-1..I-9).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/pinhole_camera.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs {

struct CameraConfig {
  std::optional<int> width_px, height_px;
  std::optional<double> fx_px, fy_px, cx_px, cy_px;
  double sigma_px = 1.0;
  double relief = 0.3;
  double mount_roll_rad = 0.0, mount_pitch_rad = 0.0, mount_yaw_rad = 1.5707963267948966;
  double mount_forward_m = 0.0, mount_starboard_m = 0.0, mount_down_m = 0.0;
  double gate_probability = 0.999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("width_px", width_px, Rule::at_least(1),
            "columns of a frame whose lens is corrected; from the calibration file, as the next five");
    v.field("height_px", height_px, Rule::at_least(1), "rows of it");
    v.field("fx_px", fx_px, Rule::positive(), "focal length of the corrected frame, along its columns");
    v.field("fy_px", fy_px, Rule::positive(), "... along its rows");
    v.field("cx_px", cx_px, Rule::any(), "column in which the camera looks straight ahead; the first is 0");
    v.field("cy_px", cy_px, Rule::any(), "row of the same");
    v.field("sigma_px", sigma_px, Rule::positive(), "noise of a keypoint, along each axis");
    v.field("relief", relief, Rule::open(0, 1),
            "standard deviation of a new point's inverse depth, as a part of what a level seabed would give");
    v.field(
        "mount_roll_rad", mount_roll_rad, Rule::closed(-4, 4),
        "mounting angles of the camera (x along the columns of the picture, y along its rows, z ahead): roll first, then pitch, then yaw");
    v.field("mount_pitch_rad", mount_pitch_rad, Rule::closed(-4, 4), "... pitch");
    v.field("mount_yaw_rad", mount_yaw_rad, Rule::closed(-4, 4), "... yaw; a quarter turn: it looks down, the top of the picture is ahead");
    v.field("mount_forward_m", mount_forward_m, Rule::any(), "lever arm from the tracked point, forward");
    v.field("mount_starboard_m", mount_starboard_m, Rule::any(), "lever arm, to starboard");
    v.field("mount_down_m", mount_down_m, Rule::any(), "lever arm, down");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "of the pairing of a keypoint with a landmark");
  }
};

/// The camera of the corrected frames; nothing where the configuration has none. Throws InvalidArgument naming what is missing of one.
[[nodiscard]] std::optional<PinholeCamera> pinhole_camera(const CameraConfig& config);

/// vehicle_T_camera: camera x along the columns, y along the rows, z ahead.
[[nodiscard]] Se3 vehicle_T_camera(const CameraConfig& config);

/// [c1 (3, m) | azimuth, elevation (rad) | inverse depth (1/m)]: the point c1 + m / rho, m the unit vector of the azimuth and elevation.
/// (I-3)
using InverseDepth = Eigen::Matrix<double, 6, 1>;

/// m = (cos b sin a, -sin b, cos b cos a), in the axes of the map: (0, 0) looks straight down.
[[nodiscard]] Eigen::Vector3d ray_direction(double azimuth_rad, double elevation_rad);

struct ConvertedPoint {
  Eigen::Vector3d map_p_point;
  Eigen::Matrix<double, 3, 6> J;  ///< of the point by the inverse depth
};
/// Throws InvalidArgument unless the inverse depth is positive: the point is at infinity or behind. (I-3)
[[nodiscard]] ConvertedPoint to_point(const InverseDepth& ray);

/// A predicted pixel with its derivatives; `L` is 3 for a point, 6 for inverse depth.
template <int L>
struct PixelPrediction {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, VehicleLayout::kSize> H_vehicle;
  Eigen::Matrix<double, 2, L> H_landmark;
};

/// Where the camera shows a point of the map; nothing when it lies behind or less than a centimetre ahead. (I-2)
[[nodiscard]] std::optional<PixelPrediction<3>> predict_pixel(const VehicleVector& state, const Eigen::Vector3d& map_p_point,
                                                              const PinholeCamera& camera, const CameraConfig& config);
/// The same for a point in inverse depth, also at infinity. (I-4)
[[nodiscard]] std::optional<PixelPrediction<6>> predict_pixel(const VehicleVector& state, const InverseDepth& ray,
                                                              const PinholeCamera& camera, const CameraConfig& config);

struct NewRay {
  InverseDepth ray;
  Eigen::Matrix<double, 6, VehicleLayout::kSize> J_vehicle;
  Matrix6d noise;  ///< added by the pixel and the relief of the seabed
};
/// A point on the ray through this pixel, at first guess where the level seabed of the state is; nothing when the ray does not go down to
/// it. (I-5), (I-6)
[[nodiscard]] std::optional<NewRay> ray_from_pixel(const VehicleVector& state, const Eigen::Vector2d& pixel, const PinholeCamera& camera,
                                                   const CameraConfig& config);

/// How far the point of a ray is from being Gaussian in space, seen from `map_p_camera`: below 0.1 it is converted. [civera2007] (I-7)
[[nodiscard]] double linearity_index(const InverseDepth& ray, double inverse_depth_sigma, const Eigen::Vector3d& map_p_camera);

}  // namespace ssjs
