#include "ssjs/pipeline/motion.hpp"

#include <algorithm>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr double kSilenceS = 5.0;
constexpr double kUnusual = 10.0;
constexpr double kForgottenS = 900.0;

/// The vehicle may have done as it was told all the time, or nothing.
void add_doubt(OdometryIncrement& increment, double dt_s) {
  GaussianSe2& moved = increment.old_T_new;
  moved.covariance.topLeftCorner<2, 2>().diagonal().array() += 0.25 * moved.mean.translation().squaredNorm();
  moved.covariance(2, 2) += dt_s > kForgottenS ? kPi * kPi / 3.0 : 0.25 * moved.mean.heading * moved.mean.heading;
}

}  // namespace

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
    if (dt_s > std::max(kSilenceS, kUnusual * usual_s_)) add_doubt(*increment_, dt_s);
  }
  if (dt_s > 0.0) usual_s_ += 0.01 * (dt_s - usual_s_);
  if (std::holds_alternative<AckermanControl>(event.record) || std::holds_alternative<VelocityControl>(event.record)) held_ = event;
}

}  // namespace ssjs
