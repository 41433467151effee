/// How an underwater vehicle moves between two samples. Thesis 5.2, 5.15 corrected; docs/math/auv.md (A-2..A-5).
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs {

/// Where the turn rates of a step come from.
enum class RotationDrive {
  kGyro,              ///< a measured input: used here, and nowhere else
  kRates,             ///< states of their own, a random walk: no gyro, and turns are followed
  kConstantAttitude,  ///< none: the thesis' model, with the turn as noise
};

/// Random walks grow with the square root of time: a sigma per sqrt(s). The gyro's sigma is of one sample held for gyro_step_s.
struct ConstantVelocityConfig {
  RotationDrive drive = RotationDrive::kGyro;
  double velocity_walk_m_s_sqrt_s = 0.02;
  double seabed_walk_m_sqrt_s = 0.05;
  double compass_walk_rad_sqrt_s = 8.726646259971648e-4;  ///< 0.05 deg
  double gyro_sigma_rad_s = 3.490658503988659e-3;         ///< 0.2 deg/s
  double gyro_step_s = 0.1;
  double gyro_bias_walk_rad_s_sqrt_s = 0.0;
  double rates_walk_rad_s_sqrt_s = 0.05;
  double attitude_walk_rad_sqrt_s = 0.1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("drive", drive,
             Choices<RotationDrive>{
                 {"gyro", RotationDrive::kGyro}, {"rates", RotationDrive::kRates}, {"constant_attitude", RotationDrive::kConstantAttitude}},
             "where the turn rates come from: a gyro, states of their own, or nowhere (the turn is noise)");
    v.field("velocity_walk_m_s_sqrt_s", velocity_walk_m_s_sqrt_s, Rule::positive(), "random walk of the velocity along each body axis");
    v.field("seabed_walk_m_sqrt_s", seabed_walk_m_sqrt_s, Rule::not_negative(), "random walk of the seabed's depth under the vehicle");
    v.field("compass_walk_rad_sqrt_s", compass_walk_rad_sqrt_s, Rule::not_negative(),
            "drift of the compass offset; 0 where it is constant");
    v.field("gyro_sigma_rad_s", gyro_sigma_rad_s, Rule::positive(), "gyro noise of one sample of gyro_step_s");
    v.field("gyro_step_s", gyro_step_s, Rule::positive(), "length of the sample that gyro_sigma_rad_s describes");
    v.field("gyro_bias_walk_rad_s_sqrt_s", gyro_bias_walk_rad_s_sqrt_s, Rule::not_negative(),
            "drift of the gyro's bias; 0 where it is constant");
    v.field("rates_walk_rad_s_sqrt_s", rates_walk_rad_s_sqrt_s, Rule::positive(), "random walk of the turn rates (drive rates)");
    v.field("attitude_walk_rad_sqrt_s", attitude_walk_rad_sqrt_s, Rule::positive(),
            "random walk of the attitude (drive constant_attitude)");
  }
};

struct VehiclePrediction {
  VehicleVector state;
  VehicleMatrix F;  ///< d(new state)/d(old state), additive
  VehicleMatrix Q;  ///< covariance added by this step
};

/// The six-degree-of-freedom model over dt_s >= 0. gyro_rad_s: body rates, used by the drive kGyro alone. Throws InvalidArgument near
/// +-90 degrees of pitch.
[[nodiscard]] VehiclePrediction predict_constant_velocity(const VehicleVector& state, const Eigen::Vector3d& gyro_rad_s, double dt_s,
                                                          const ConstantVelocityConfig& config);

/// The four-degree-of-freedom model, for a vehicle that keeps level by itself: (x, y, z, yaw, velocity 3). With the yaw rate of a gyro
/// (drive kGyro; kConstantAttitude: none).
using LevelVehicleVector = Eigen::Matrix<double, 7, 1>;
struct LevelVehiclePrediction {
  LevelVehicleVector state;
  Eigen::Matrix<double, 7, 7> F;
  Eigen::Matrix<double, 7, 7> Q;
};
[[nodiscard]] LevelVehiclePrediction predict_constant_velocity_level(const LevelVehicleVector& state, double yaw_rate_rad_s, double dt_s,
                                                                     const ConstantVelocityConfig& config);

}  // namespace ssjs
