/// Where an underwater vehicle is by its own sensors alone: what a survey is compared with.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/features/navigation_tick.hpp"
#include "ssjs/geometry/se3.hpp"
#include "ssjs/sensors/navigation_sensors.hpp"

namespace ssjs {

/// The last velocity, along the last attitude, integrated from the origin. The heading is the compass less its first reading, or the
/// integral of the gyro where there is no compass; depth is the last one measured.
class DeadReckoning {
 public:
  explicit DeadReckoning(const VelocityLogConfig& velocity_log) : velocity_log_(velocity_log) {}

  void feed(const NavigationTick& tick);

  [[nodiscard]] const Se3& start_T_vehicle() const { return pose_; }

 private:
  VelocityLogConfig velocity_log_;
  Se3 pose_;
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();  ///< body axes
  Eigen::Vector3d rates_rad_s_ = Eigen::Vector3d::Zero();
  std::optional<double> first_compass_rad_;
  std::optional<double> time_s_;
};

}  // namespace ssjs
