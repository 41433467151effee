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

/// Velocity commands hold until the next one; after a silence, longer than 5 s and than ten times the usual between two events, that is a
/// guess, and the increment knows it: half its way in x and y and half its turn are added to its standard deviations, and after a quarter
/// of an hour it knows nothing of the heading (as A-26 of auv.md). An increment leads from the one before to its time. Whatever the
/// odometry, a motion is a pose increment (G-1), the same for every frame that follows it.
class OdometryMotion {
 public:
  explicit OdometryMotion(const VehicleConfig& config) : config_(config) {}

  /// The next event, of any kind; check_event() must have let it pass.
  void take(const Event& event);

  /// From the event before to the last one taken; nothing where that event brings no motion.
  [[nodiscard]] const std::optional<OdometryIncrement>& increment() const { return increment_; }

 private:
  VehicleConfig config_;
  std::optional<double> time_s_;
  double usual_s_ = 0.0;       ///< between two events, lately
  std::optional<Event> held_;  ///< command from now on
  std::optional<OdometryIncrement> increment_;
};

}  // namespace ssjs
