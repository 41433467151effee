/// The configured motion model.
#pragma once

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// Holds a velocity command (AckermanControl or VelocityControl) for dt_s.
[[nodiscard]] MotionPrediction hold_command(const Se2& frame_T_vehicle, const Event& command, double dt_s, const VehicleConfig& config);

}  // namespace ssjs
