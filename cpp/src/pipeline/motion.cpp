#include "ssjs/pipeline/motion.hpp"

namespace ssjs {

MotionPrediction hold_command(const Se2& frame_T_vehicle, const Event& command, double dt_s, const VehicleConfig& config) {
  if (const auto* control = std::get_if<AckermanControl>(&command.record)) {
    return predict_ackerman(frame_T_vehicle, *control, dt_s, config.ackerman);
  }
  return predict_unicycle(frame_T_vehicle, std::get<VelocityControl>(command.record), dt_s, config.unicycle);
}

OdometryIncrement command_increment(const Event& command, double dt_s, const VehicleConfig& config) {
  const MotionPrediction from_origin = hold_command({}, command, dt_s, config);
  return {{from_origin.submap_T_vehicle, from_origin.Q}};  // (G-1)
}

void OdometryMotion::take(const Event& event) {
  const double dt_s = time_s_ ? event.time_s - *time_s_ : 0.0;
  time_s_ = event.time_s;
  increment_.reset();
  if (const auto* increment = std::get_if<OdometryIncrement>(&event.record)) {
    increment_ = calibrated(*increment, config_.increments);
  } else if (held_ && dt_s > 0.0) {
    increment_ = command_increment(*held_, dt_s, config_);
  }
  if (std::holds_alternative<AckermanControl>(event.record) || std::holds_alternative<VelocityControl>(event.record)) held_ = event;
}

}  // namespace ssjs
