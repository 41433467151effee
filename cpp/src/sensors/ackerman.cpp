#include "ssjs/sensors/ackerman.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

[[noreturn]] void refuse(const AckermanControl& control, double dt_s) {
  if (!(dt_s >= 0.0) || !std::isfinite(dt_s)) throw InvalidArgument("predict_ackerman dt_s", dt_s, "must be zero or positive, and finite");
  if (!std::isfinite(control.speed_m_s)) throw InvalidArgument("AckermanControl.speed_m_s", control.speed_m_s, "must be finite");
  throw InvalidArgument(
      "AckermanControl.steering_rad", control.steering_rad,
      "after calibration it must lie in (-pi/2, pi/2) and keep the encoder wheel rolling forward: tan(steering) H / L < 1");
}

double calibrated_steering(const AckermanControl& control, const AckermanConfig& config) {
  return config.steering_scale * control.steering_rad + config.steering_offset_rad;
}

/// Below half a right angle an encoder wheel inside the wheelbase always rolls forward.
bool is_drivable(double steering, const AckermanConfig& config) {
  if (std::abs(steering) <= 0.25 * kPi && std::abs(config.encoder_offset_m) < config.wheelbase_m) return true;
  return std::abs(steering) < 0.5 * kPi && 1.0 - std::tan(steering) * config.encoder_offset_m / config.wheelbase_m > 0.0;
}

}  // namespace

void check_drivable(const AckermanControl& control, const AckermanConfig& config) {
  if (!std::isfinite(control.speed_m_s) || !is_drivable(calibrated_steering(control, config), config)) refuse(control, 0.0);
}

MotionPrediction predict_ackerman(const Se2& submap_T_vehicle, const AckermanControl& control, double dt_s, const AckermanConfig& config) {
  const double L = config.wheelbase_m;
  const double H = config.encoder_offset_m;
  const double steering = calibrated_steering(control, config);
  if (!(dt_s >= 0.0) || !std::isfinite(dt_s) || !std::isfinite(control.speed_m_s) || !is_drivable(steering, config)) refuse(control, dt_s);
  const double tangent = std::tan(steering);
  const double q = 1.0 - tangent * H / L;

  const double c = std::cos(submap_T_vehicle.heading);
  const double s = std::sin(submap_T_vehicle.heading);
  const double A = config.reference_forward_m * s + config.reference_left_m * c;
  const double B = config.reference_forward_m * c - config.reference_left_m * s;
  const double w = tangent / L;  // curvature of the rear axle's path, 1/m
  const double axle_speed = control.speed_m_s / q;
  const Eigen::Vector3d u(c - w * A, s + w * B, w);  // change of the pose per metre of the rear axle
  const double distance = dt_s * axle_speed;

  MotionPrediction prediction;
  prediction.submap_T_vehicle = {submap_T_vehicle.x + distance * u.x(), submap_T_vehicle.y + distance * u.y(),
                                 wrap_angle(submap_T_vehicle.heading + distance * u.z())};  // (M-1)
  prediction.F << 1.0, 0.0, -distance * u.y(),                                              // (M-2)
      0.0, 1.0, distance * u.x(),                                                           //
      0.0, 0.0, 1.0;
  if (control.speed_m_s == 0.0) {
    prediction.Q.setZero();
    return prediction;
  }

  // (M-3) rates of the pose with respect to the measured speed and the measured steering
  const double secant_squared = 1.0 + tangent * tangent;
  const Eigen::Vector3d g_speed = u / q;
  const Eigen::Vector3d g_steering =
      (config.steering_scale * secant_squared * axle_speed / L) * (u * (H / q) + Eigen::Vector3d(-A, B, 1.0));
  const Eigen::Vector3d g_lateral(-s, c, 0.0);
  // (M-4) dt^2 * sigma^2 * (noise_step / dt): white noise, and no division by dt
  const double scale = dt_s * config.noise_step_s;
  const double speed_variance = scale * config.speed_sigma_m_s * config.speed_sigma_m_s;
  const double steering_variance = scale * config.steering_sigma_rad * config.steering_sigma_rad;
  const double lateral_variance = scale * config.lateral_sigma_m_s * config.lateral_sigma_m_s;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = row; column < 3; ++column) {
      prediction.Q(row, column) = speed_variance * g_speed(row) * g_speed(column) +
                                  steering_variance * g_steering(row) * g_steering(column) +
                                  lateral_variance * g_lateral(row) * g_lateral(column);
      prediction.Q(column, row) = prediction.Q(row, column);
    }
  }
  return prediction;
}

}  // namespace ssjs
