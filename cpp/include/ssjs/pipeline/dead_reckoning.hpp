/// Where an underwater vehicle is by its own sensors alone: what a survey is compared with.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/features/navigation_tick.hpp"
#include "ssjs/geometry/se3.hpp"
#include "ssjs/sensors/navigation_sensors.hpp"

namespace ssjs {

/// The last velocity, along the last attitude, integrated from the origin. The heading is the compass less its first reading (or, in
/// a world aligned to north, less the offset given), or the integral of the gyro where there is no compass; depth is the last measured.
class DeadReckoning {
 public:
  DeadReckoning(const VelocityLogConfig& velocity_log, const std::optional<double>& north_offset_rad)
      : velocity_log_(velocity_log), compass_zero_rad_(north_offset_rad) {}

  void feed(const NavigationTick& tick);

  [[nodiscard]] const Se3& start_T_vehicle() const { return pose_; }

 private:
  VelocityLogConfig velocity_log_;
  Se3 pose_;
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();  ///< body axes
  Eigen::Vector3d rates_rad_s_ = Eigen::Vector3d::Zero();
  std::optional<double> compass_zero_rad_;  ///< the reading where the heading is 0
  bool compass_spoke_ = false;
  std::optional<double> time_s_;
};

}  // namespace ssjs
