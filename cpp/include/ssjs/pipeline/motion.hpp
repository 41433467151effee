/// The configured motion model.
#pragma once

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// Holds a velocity command (AckermanControl or VelocityControl) for dt_s.
[[nodiscard]] MotionPrediction hold_command(const Se2& frame_T_vehicle, const Event& command, double dt_s, const VehicleConfig& config);

/// The pose change that a velocity command makes in dt_s, with its covariance: the odometry increment of the augmented EKF, whatever the
/// vehicle. docs/math/single_map.md (G-1).
[[nodiscard]] OdometryIncrement command_increment(const Event& command, double dt_s, const VehicleConfig& config);

}  // namespace ssjs
