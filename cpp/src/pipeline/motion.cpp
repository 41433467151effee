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
  dt_s_ = time_s_ ? event.time_s - *time_s_ : 0.0;
  time_s_ = event.time_s;
  held_ = next_;
  increment_.reset();
  if (const auto* increment = std::get_if<OdometryIncrement>(&event.record)) {
    increment_ = *increment;
  } else if (std::holds_alternative<AckermanControl>(event.record) || std::holds_alternative<VelocityControl>(event.record)) {
    next_ = event;
  }
}

std::optional<MotionPrediction> OdometryMotion::from(const Se2& frame_T_vehicle) const {
  if (increment_) return predict_increment(frame_T_vehicle, *increment_);
  if (!held_ || !(dt_s_ > 0.0)) return std::nullopt;
  if (by_increments_) return predict_increment(frame_T_vehicle, command_increment(*held_, dt_s_, config_));
  return hold_command(frame_T_vehicle, *held_, dt_s_, config_);
}

}  // namespace ssjs
