/// What the navigation sensors of an underwater vehicle say of its state, one row each where nothing else is said. Thesis 5.5-5.10, 5.13,
/// 5.14 corrected; docs/math/auv.md (A-6..A-10).
#pragma once

#include <optional>

#include "ssjs/base/archive.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs {

/// Roll and pitch of an inclinometer or AHRS, rad. The yaw of the same device belongs to the compass.
struct AttitudeConfig {
  double sigma_rad = 8.726646259971648e-3;  ///< 0.5 deg
  double gate_probability = 0.9999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sigma_rad", sigma_rad, Rule::positive(), "noise of roll and of pitch");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "samples less likely than this are refused");
  }
};

/// Heading from magnetic or true north, rad, clockwise. Its datum is unknown: the state holds reading minus yaw in the map.
struct CompassConfig {
  double sigma_rad = 0.0174532925199433;  ///< 1 deg
  double gate_probability = 0.9999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sigma_rad", sigma_rad, Rule::positive(), "white noise of a reading; what is constant or drifts is the offset's");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "samples less likely than this are refused");
  }
};

/// Pressure depth, m, positive down.
struct DepthConfig {
  double sigma_m = 0.05;
  double gate_probability = 0.9999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sigma_m", sigma_m, Rule::positive(), "noise of a reading");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "samples less likely than this are refused");
  }
};

/// Height above the seabed, m.
struct AltitudeConfig {
  double sigma_m = 0.1;
  bool along_body_axis = false;  ///< the raw range of a beam fixed to the body; false: already made vertical
  double gate_probability = 0.999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sigma_m", sigma_m, Rule::positive(), "noise of a reading");
    v.field("along_body_axis", along_body_axis, "readings are slant ranges along the vehicle's down axis, over a level seabed");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "samples less likely than this are refused");
  }
};

/// Doppler velocity log: velocity over the ground along the axes of the instrument, m/s.
struct VelocityLogConfig {
  double sigma_m_s = 0.015;
  double mount_roll_rad = 0.0, mount_pitch_rad = 0.0, mount_yaw_rad = 0.0;    ///< vehicle_R_log = Rz(yaw) Ry(pitch) Rx(roll)
  double mount_forward_m = 0.0, mount_starboard_m = 0.0, mount_down_m = 0.0;  ///< of the instrument in the vehicle
  double gate_probability = 0.9999;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sigma_m_s", sigma_m_s, Rule::positive(), "noise along each axis, where the log gives none");
    v.field("mount_roll_rad", mount_roll_rad, Rule::closed(-4, 4), "mounting angles: roll first, then pitch, then yaw");
    v.field("mount_pitch_rad", mount_pitch_rad, Rule::closed(-4, 4), "mounting angles: roll first, then pitch, then yaw");
    v.field("mount_yaw_rad", mount_yaw_rad, Rule::closed(-4, 4), "mounting angles: roll first, then pitch, then yaw");
    v.field("mount_forward_m", mount_forward_m, Rule::any(), "lever arm from the tracked point, forward");
    v.field("mount_starboard_m", mount_starboard_m, Rule::any(), "lever arm, to starboard");
    v.field("mount_down_m", mount_down_m, Rule::any(), "lever arm, down");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "samples less likely than this are refused");
  }
};

struct VelocitySample {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< axes of the instrument
  bool bottom_lock = true;                                 ///< false: not a velocity over the ground, and never used
  std::optional<double> sigma_m_s;                         ///< where the log gives it

  void archive(Archive& a) {
    a("velocity_m_s", velocity_m_s);
    a("bottom_lock", bottom_lock);
    a("sigma_m_s", sigma_m_s);
  }
};

/// Turn rates for the lever arm of the velocity log: exact inputs here, their noise is in the prediction.
[[nodiscard]] VehicleRows attitude_rows(const VehicleVector& state, const Eigen::Vector2d& roll_pitch_rad, const AttitudeConfig& config);
[[nodiscard]] VehicleRows compass_rows(const VehicleVector& state, double heading_rad, const CompassConfig& config);
[[nodiscard]] VehicleRows depth_rows(const VehicleVector& state, double depth_m, const DepthConfig& config);
[[nodiscard]] VehicleRows altitude_rows(const VehicleVector& state, double altitude_m, const AltitudeConfig& config);
/// body_rates_rad_s: of the gyro, for the lever arm; nothing where the rates are states (then they are corrected too).
[[nodiscard]] VehicleRows velocity_log_rows(const VehicleVector& state, const VelocitySample& sample,
                                            const std::optional<Eigen::Vector3d>& body_rates_rad_s, const VelocityLogConfig& config);

}  // namespace ssjs
