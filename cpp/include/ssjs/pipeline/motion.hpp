/// The configured motion model, and how odometry events drive it.
#pragma once

#include <optional>

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// Holds a velocity command (AckermanControl or VelocityControl) for dt_s.
[[nodiscard]] MotionPrediction hold_command(const Se2& frame_T_vehicle, const Event& command, double dt_s, const VehicleConfig& config);

/// Velocity commands hold until the next one; an increment leads from the one before to its time.
class OdometryMotion {
 public:
  explicit OdometryMotion(const VehicleConfig& config) : config_(config) {}

  /// The next event, of any kind; check_event() must have let it pass.
  void take(const Event& event);

  /// The motion from the event before to the last one taken, starting at a pose; nothing where that event brings none.
  [[nodiscard]] std::optional<MotionPrediction> from(const Se2& frame_T_vehicle) const;

 private:
  VehicleConfig config_;
  std::optional<double> time_s_;
  double dt_s_ = 0.0;
  std::optional<Event> held_;  ///< command of the last dt_s_
  std::optional<Event> next_;  ///< command from now on
  std::optional<OdometryIncrement> increment_;
};

}  // namespace ssjs
