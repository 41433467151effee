/// The configured motion model, and how odometry events drive it.
#pragma once

#include <optional>

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// Holds a velocity command (AckermanControl or VelocityControl) for dt_s.
[[nodiscard]] MotionPrediction hold_command(const Se2& frame_T_vehicle, const Event& command, double dt_s, const VehicleConfig& config);

/// The pose change that a velocity command makes in dt_s, with its covariance: the odometry increment of the augmented EKF, whatever the
/// vehicle. docs/math/single_map.md (G-1).
[[nodiscard]] OdometryIncrement command_increment(const Event& command, double dt_s, const VehicleConfig& config);
/// Velocity commands hold until the next one; an increment leads from the one before to its time.
class OdometryMotion {
 public:
  /// by_increments: commands become odometry increments first (G-1), as the augmented EKF has it.
  explicit OdometryMotion(const VehicleConfig& config, bool by_increments = false) : config_(config), by_increments_(by_increments) {}

  /// The next event, of any kind; check_event() must have let it pass.
  void take(const Event& event);

  /// The motion from the event before to the last one taken, starting at a pose; nothing where that event brings none.
  [[nodiscard]] std::optional<MotionPrediction> from(const Se2& frame_T_vehicle) const;

 private:
  VehicleConfig config_;
  bool by_increments_;
  std::optional<double> time_s_;
  double dt_s_ = 0.0;
  std::optional<Event> held_;  ///< command of the last dt_s_
  std::optional<Event> next_;  ///< command from now on
  std::optional<OdometryIncrement> increment_;
};

}  // namespace ssjs
