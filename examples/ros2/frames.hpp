/// Between the conventions of ROS (REP 103: world east-north-up, body forward-left-up) and those of ssjs::online (world north-east-down,
/// body forward-starboard-down). Angles are those of roll about x, then pitch about y, then yaw about z, all axes fixed, rad:
///   roll = roll_ros, pitch = -pitch_ros, yaw = pi/2 - yaw_ros.
/// Each function is its own inverse where both sides have the same type.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace ssjs_ros {

using Vector = std::array<double, 3>;
using Covariance = std::array<double, 36>;  ///< row-major, of (x, y, z, roll, pitch, yaw)

constexpr double kPi = 3.14159265358979323846;

struct Angles {
  double roll, pitch, yaw;
};
struct Quaternion {
  double w, x, y, z;
};

/// Body vectors: velocities, turn rates, positions of objects.
inline Vector other_body(const Vector& v) { return {v[0], -v[1], -v[2]}; }
/// World vectors.
inline Vector other_world(const Vector& v) { return {v[1], v[0], -v[2]}; }
inline Angles other_angles(const Angles& a) { return {a.roll, -a.pitch, std::remainder(0.5 * kPi - a.yaw, 2.0 * kPi)}; }

/// x and y change places; z, pitch and yaw change their signs.
inline Covariance other_covariance(const Covariance& P) {
  constexpr std::array<std::size_t, 6> from = {1, 0, 2, 3, 4, 5};
  constexpr std::array<double, 6> sign = {1.0, 1.0, -1.0, 1.0, -1.0, -1.0};
  Covariance out{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) out[6 * i + j] = sign[i] * sign[j] * P[6 * from[i] + from[j]];
  }
  return out;
}

/// Of a unit quaternion. Pitch lies in [-pi/2, pi/2]; at its ends roll is what roll and yaw are together.
inline Angles angles_of(const Quaternion& q) {
  const double sine = 2.0 * (q.w * q.y - q.z * q.x);
  const double pitch = std::abs(sine) >= 1.0 ? std::copysign(0.5 * kPi, sine) : std::asin(sine);
  return {std::atan2(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (q.x * q.x + q.y * q.y)), pitch,
          std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))};
}

inline Quaternion quaternion_of(const Angles& a) {
  const double cr = std::cos(0.5 * a.roll), sr = std::sin(0.5 * a.roll);
  const double cp = std::cos(0.5 * a.pitch), sp = std::sin(0.5 * a.pitch);
  const double cy = std::cos(0.5 * a.yaw), sy = std::sin(0.5 * a.yaw);
  return {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy};
}

/// North and east of an origin, m, for points within some tens of kilometres: arcs along the radii of curvature of WGS 84 at the origin.
inline std::array<double, 2> north_east(double latitude_deg, double longitude_deg, double origin_latitude_deg,
                                        double origin_longitude_deg) {
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double degree = kPi / 180.0, sine = std::sin(origin_latitude_deg * degree);
  const double w2 = 1.0 - e2 * sine * sine, normal = a / std::sqrt(w2), meridian = normal * (1.0 - e2) / w2;
  const double turned_deg = std::remainder(longitude_deg - origin_longitude_deg, 360.0);
  return {meridian * (latitude_deg - origin_latitude_deg) * degree, normal * std::cos(origin_latitude_deg * degree) * turned_deg * degree};
}

/// Depth below the surface of an absolute pressure, m. The mean density of the water column, kg/m^3.
inline double depth_of(double pressure_pa, double surface_pa, double density) {
  constexpr double gravity = 9.80665;
  return (pressure_pa - surface_pa) / (density * gravity);
}

}  // namespace ssjs_ros
