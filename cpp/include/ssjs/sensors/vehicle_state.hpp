/// The state of an underwater vehicle in a levelled map, and the rows that a sensor adds about it. docs/math/auv.md (A-1).
#pragma once

#include <Eigen/Core>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/archive.hpp"
#include "ssjs/geometry/se3.hpp"

namespace ssjs {

/// Where each quantity lies. The map is level: x, y and yaw from the map's start, z (depth, positive down), roll and pitch absolute. A
/// quantity that a vehicle does not use has no variance and no noise, and stays the constant it was.
struct VehicleLayout {
  static constexpr Eigen::Index kPosition = 0;        ///< 3, m
  static constexpr Eigen::Index kAttitude = 3;        ///< 3, roll, pitch, yaw, rad
  static constexpr Eigen::Index kVelocity = 6;        ///< 3, along the body axes, m/s
  static constexpr Eigen::Index kSeabed = 9;          ///< depth of the seabed under the vehicle, m; altitude = seabed - z
  static constexpr Eigen::Index kCompassOffset = 10;  ///< compass reading minus yaw in the map, now, rad
  static constexpr Eigen::Index kStartOffset = 11;    ///< the same when the map started
  static constexpr Eigen::Index kRates = 12;          ///< 3, turn rates about the body axes, rad/s: for a vehicle without a gyro
  static constexpr Eigen::Index kGyroBias = 15;       ///< 3, gyro reading minus turn rate, rad/s
  static constexpr Eigen::Index kLogScale = 18;       ///< of the velocity log: reading = (1 + scale) times the velocity
  static constexpr Eigen::Index kLogYaw = 19;         ///< of the velocity log: its yaw beyond the mounting angle, rad
  static constexpr Eigen::Index kSize = 20;
};

using VehicleVector = Eigen::Matrix<double, VehicleLayout::kSize, 1>;
using VehicleMatrix = Eigen::Matrix<double, VehicleLayout::kSize, VehicleLayout::kSize>;

[[nodiscard]] inline Eigen::Vector3d position_of(const VehicleVector& x) { return x.segment<3>(VehicleLayout::kPosition); }
[[nodiscard]] inline Eigen::Vector3d attitude_of(const VehicleVector& x) { return x.segment<3>(VehicleLayout::kAttitude); }
[[nodiscard]] inline Eigen::Vector3d velocity_of(const VehicleVector& x) { return x.segment<3>(VehicleLayout::kVelocity); }
[[nodiscard]] inline Eigen::Vector3d rates_of(const VehicleVector& x) { return x.segment<3>(VehicleLayout::kRates); }
[[nodiscard]] inline Eigen::Vector3d gyro_bias_of(const VehicleVector& x) { return x.segment<3>(VehicleLayout::kGyroBias); }
[[nodiscard]] inline Se3 map_T_vehicle(const VehicleVector& x) { return {position_of(x), attitude_of(x)}; }

/// Roll, pitch, yaw and both compass offsets back into [-pi, pi).
inline void wrap_vehicle(Eigen::Ref<VehicleVector> x) {
  for (const Eigen::Index i : {3, 4, 5, 10, 11}) x(i) = wrap_angle(x(i));
}

/// Up to three linearised components of one sensor at the current estimate: residual = measured - predicted = H error + noise, noise
/// N(0, R), where error = truth - estimate.
struct VehicleRows {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> residual;
  Eigen::Matrix<double, Eigen::Dynamic, VehicleLayout::kSize, 0, 3, VehicleLayout::kSize> H;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> R;

  explicit VehicleRows(Eigen::Index rows = 0) {
    residual.setZero(rows);
    H.setZero(rows, VehicleLayout::kSize);
    R.setZero(rows, rows);
  }

  void archive(Archive& a) {
    a("residual", residual);
    a("H", H);
    a("R", R);
  }
};

}  // namespace ssjs
