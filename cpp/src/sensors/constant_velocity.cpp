#include "ssjs/sensors/constant_velocity.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

void check_step(double dt_s) {
  if (!(dt_s >= 0.0) || !std::isfinite(dt_s)) {
    throw InvalidArgument("predict_constant_velocity dt_s", dt_s, "must be zero or positive, and finite");
  }
}

double squared(double x) { return x * x; }

/// Variance of the angle that the noise of the drive adds about each body axis in dt.
double turn_variance(double dt_s, const ConstantVelocityConfig& config) {
  if (config.drive == RotationDrive::kGyro) return squared(config.gyro_sigma_rad_s) * config.gyro_step_s * dt_s;
  return squared(config.attitude_walk_rad_sqrt_s) * dt_s;
}

}  // namespace

VehiclePrediction predict_constant_velocity(const VehicleVector& state, const Eigen::Vector3d& gyro_rad_s, double dt_s,
                                            const ConstantVelocityConfig& config) {
  check_step(dt_s);
  const Eigen::Vector3d rpy = attitude_of(state);
  const Eigen::Vector3d velocity = velocity_of(state);
  const bool rates_are_states = config.drive == RotationDrive::kRates;
  Eigen::Vector3d rates = Eigen::Vector3d::Zero();
  if (config.drive == RotationDrive::kGyro) rates = gyro_rad_s - gyro_bias_of(state);
  if (rates_are_states) rates = rates_of(state);
  const Eigen::Matrix3d R = rotation_from_rpy(rpy);
  const Eigen::Matrix3d E_inverse = inverse_euler_rate_matrix(rpy);

  VehiclePrediction prediction;
  prediction.state = state;
  prediction.state.segment<3>(Layout::kPosition) += dt_s * (R * velocity);
  prediction.state.segment<3>(Layout::kAttitude) += dt_s * (E_inverse * rates);
  wrap_vehicle(prediction.state);

  VehicleMatrix& F = prediction.F;
  F.setIdentity();
  F.block<3, 3>(Layout::kPosition, Layout::kAttitude) = dt_s * rotate_jacobian(rpy, velocity);
  F.block<3, 3>(Layout::kPosition, Layout::kVelocity) = dt_s * R;
  F.block<3, 3>(Layout::kAttitude, Layout::kAttitude) += dt_s * euler_rates_jacobian(rpy, rates);

  VehicleMatrix& Q = prediction.Q;
  Q.setZero();
  const double velocity_variance = squared(config.velocity_walk_m_s_sqrt_s) * dt_s;
  Q.block<3, 3>(Layout::kPosition, Layout::kPosition).diagonal().setConstant(0.25 * dt_s * dt_s * velocity_variance);
  Q.block<3, 3>(Layout::kPosition, Layout::kVelocity) = 0.5 * dt_s * velocity_variance * R;
  Q.block<3, 3>(Layout::kVelocity, Layout::kPosition) = 0.5 * dt_s * velocity_variance * R.transpose();
  Q.block<3, 3>(Layout::kVelocity, Layout::kVelocity).diagonal().setConstant(velocity_variance);
  if (rates_are_states) {
    const double rates_variance = squared(config.rates_walk_rad_s_sqrt_s) * dt_s;
    F.block<3, 3>(Layout::kAttitude, Layout::kRates) = dt_s * E_inverse;
    Q.block<3, 3>(Layout::kAttitude, Layout::kAttitude) = 0.25 * dt_s * dt_s * rates_variance * E_inverse * E_inverse.transpose();
    Q.block<3, 3>(Layout::kAttitude, Layout::kRates) = 0.5 * dt_s * rates_variance * E_inverse;
    Q.block<3, 3>(Layout::kRates, Layout::kAttitude) = 0.5 * dt_s * rates_variance * E_inverse.transpose();
    Q.block<3, 3>(Layout::kRates, Layout::kRates).diagonal().setConstant(rates_variance);
  } else {
    Q.block<3, 3>(Layout::kAttitude, Layout::kAttitude) = turn_variance(dt_s, config) * E_inverse * E_inverse.transpose();
  }
  if (config.drive == RotationDrive::kGyro) {
    F.block<3, 3>(Layout::kAttitude, Layout::kGyroBias) = -dt_s * E_inverse;
    Q.block<3, 3>(Layout::kGyroBias, Layout::kGyroBias).diagonal().setConstant(squared(config.gyro_bias_walk_rad_s_sqrt_s) * dt_s);
  }
  Q(Layout::kSeabed, Layout::kSeabed) = squared(config.seabed_walk_m_sqrt_s) * dt_s;
  Q(Layout::kCompassOffset, Layout::kCompassOffset) = squared(config.compass_walk_rad_sqrt_s) * dt_s;
  return prediction;
}

LevelVehiclePrediction predict_constant_velocity_level(const LevelVehicleVector& state, double yaw_rate_rad_s, double dt_s,
                                                       const ConstantVelocityConfig& config) {
  check_step(dt_s);
  if (config.drive == RotationDrive::kRates) {
    throw InvalidArgument("ConstantVelocityConfig.drive", "rates",
                          "the level model has no turn rate among its states: gyro or constant_attitude");
  }
  const double rate = config.drive == RotationDrive::kGyro ? yaw_rate_rad_s : 0.0;
  const Eigen::Vector3d rpy(0.0, 0.0, state(3));
  const Eigen::Vector3d velocity = state.tail<3>();
  const Eigen::Matrix3d R = rotation_from_rpy(rpy);

  LevelVehiclePrediction prediction;
  prediction.state = state;
  prediction.state.head<3>() += dt_s * (R * velocity);
  prediction.state(3) = wrap_angle(state(3) + dt_s * rate);
  prediction.F.setIdentity();
  prediction.F.block<3, 1>(0, 3) = dt_s * rotate_jacobian(rpy, velocity).col(2);
  prediction.F.block<3, 3>(0, 4) = dt_s * R;
  const double velocity_variance = squared(config.velocity_walk_m_s_sqrt_s) * dt_s;
  prediction.Q.setZero();
  prediction.Q.topLeftCorner<3, 3>().diagonal().setConstant(0.25 * dt_s * dt_s * velocity_variance);
  prediction.Q.block<3, 3>(0, 4) = 0.5 * dt_s * velocity_variance * R;
  prediction.Q.block<3, 3>(4, 0) = 0.5 * dt_s * velocity_variance * R.transpose();
  prediction.Q.block<3, 3>(4, 4).diagonal().setConstant(velocity_variance);
  prediction.Q(3, 3) = turn_variance(dt_s, config);
  return prediction;
}

}  // namespace ssjs
