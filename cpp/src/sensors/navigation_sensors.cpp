#include "ssjs/sensors/navigation_sensors.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

void require_finite(const char* what, double value) {
  if (!std::isfinite(value)) throw InvalidArgument(what, value, "must be finite: a sample that is missing is left out of the tick");
}

double squared(double x) { return x * x; }

}  // namespace

VehicleRows attitude_rows(const VehicleVector& state, const Eigen::Vector2d& roll_pitch_rad, const AttitudeConfig& config) {
  require_finite("NavigationTick.roll_pitch_rad", roll_pitch_rad.sum());
  VehicleRows rows(2);
  rows.residual << angle_difference(roll_pitch_rad.x(), state(Layout::kAttitude)),
      angle_difference(roll_pitch_rad.y(), state(Layout::kAttitude + 1));
  rows.H(0, Layout::kAttitude) = 1.0;
  rows.H(1, Layout::kAttitude + 1) = 1.0;
  rows.R.diagonal().setConstant(squared(config.sigma_rad));
  return rows;
}

VehicleRows compass_rows(const VehicleVector& state, double heading_rad, const CompassConfig& config) {
  require_finite("NavigationTick.compass_rad", heading_rad);
  VehicleRows rows(1);
  rows.residual(0) = angle_difference(heading_rad, state(Layout::kAttitude + 2) + state(Layout::kCompassOffset));
  rows.H(0, Layout::kAttitude + 2) = 1.0;
  rows.H(0, Layout::kCompassOffset) = 1.0;
  rows.R(0, 0) = squared(config.sigma_rad);
  return rows;
}

VehicleRows depth_rows(const VehicleVector& state, double depth_m, const DepthConfig& config) {
  require_finite("NavigationTick.depth_m", depth_m);
  VehicleRows rows(1);
  rows.residual(0) = depth_m - state(Layout::kPosition + 2);
  rows.H(0, Layout::kPosition + 2) = 1.0;
  rows.R(0, 0) = squared(config.sigma_m);
  return rows;
}

VehicleRows altitude_rows(const VehicleVector& state, double altitude_m, const AltitudeConfig& config) {
  require_finite("NavigationTick.altitude_m", altitude_m);
  const double roll = state(Layout::kAttitude);
  const double pitch = state(Layout::kAttitude + 1);
  const double altitude = state(Layout::kSeabed) - state(Layout::kPosition + 2);
  const double slant = config.along_body_axis ? 1.0 / (std::cos(roll) * std::cos(pitch)) : 1.0;
  VehicleRows rows(1);
  rows.residual(0) = altitude_m - altitude * slant;
  rows.H(0, Layout::kSeabed) = slant;
  rows.H(0, Layout::kPosition + 2) = -slant;
  if (config.along_body_axis) {
    rows.H(0, Layout::kAttitude) = altitude * slant * std::tan(roll);
    rows.H(0, Layout::kAttitude + 1) = altitude * slant * std::tan(pitch);
  }
  rows.R(0, 0) = squared(config.sigma_m);
  return rows;
}

VehicleRows velocity_log_rows(const VehicleVector& state, const VelocitySample& sample,
                              const std::optional<Eigen::Vector3d>& body_rates_rad_s, const VelocityLogConfig& config) {
  require_finite("VelocitySample.velocity_m_s", sample.velocity_m_s.sum());
  if (!sample.bottom_lock) {
    throw InvalidArgument("VelocitySample.bottom_lock", "false", "without bottom lock there is no velocity over the ground: no rows");
  }
  const Eigen::Matrix3d log_R_vehicle =
      rotation_from_rpy({config.mount_roll_rad, config.mount_pitch_rad, config.mount_yaw_rad}).transpose();
  const Eigen::Vector3d lever(config.mount_forward_m, config.mount_starboard_m, config.mount_down_m);
  const Eigen::Vector3d rates = body_rates_rad_s ? Eigen::Vector3d(*body_rates_rad_s - gyro_bias_of(state)) : rates_of(state);
  // the instrument turned a little more about the vehicle's down axis
  const Eigen::Vector3d more(0.0, 0.0, state(Layout::kLogYaw));
  const Eigen::Matrix3d M = (1.0 + state(Layout::kLogScale)) * log_R_vehicle * rotation_from_rpy(more).transpose();
  const Eigen::Vector3d velocity = velocity_of(state) + skew(rates) * lever;
  VehicleRows rows(3);
  rows.residual = sample.velocity_m_s - M * velocity;
  rows.H.block<3, 3>(0, Layout::kVelocity) = M;
  if (body_rates_rad_s) {
    rows.H.block<3, 3>(0, Layout::kGyroBias) = M * skew(lever);
  } else {
    rows.H.block<3, 3>(0, Layout::kRates) = -M * skew(lever);
  }
  rows.H.col(Layout::kLogScale) = log_R_vehicle * rotation_from_rpy(more).transpose() * velocity;
  rows.H.col(Layout::kLogYaw) = (1.0 + state(Layout::kLogScale)) * log_R_vehicle * inverse_rotate_jacobian(more, velocity).col(2);
  rows.R.diagonal().setConstant(squared(sample.sigma_m_s.value_or(config.sigma_m_s)));
  return rows;
}

}  // namespace ssjs
