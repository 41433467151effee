#include "ssjs/pipeline/dead_reckoning.hpp"

#include <Eigen/Geometry>

namespace ssjs {

void DeadReckoning::feed(const NavigationTick& tick) {
  if (time_s_) {
    const double dt = tick.time_s - *time_s_;
    const Eigen::Vector3d old_rpy = pose_.rpy;
    pose_.translation.head<2>() += dt * (pose_.rotation() * velocity_m_s_).head<2>();
    if (!compass_spoke_) {
      pose_.rpy(2) = wrap_angle(old_rpy(2) + dt * (inverse_euler_rate_matrix(old_rpy) * rates_rad_s_)(2));
    }
  }
  time_s_ = tick.time_s;
  if (tick.gyro_rad_s) rates_rad_s_ = *tick.gyro_rad_s;
  if (tick.roll_pitch_rad) pose_.rpy.head<2>() = *tick.roll_pitch_rad;
  if (tick.compass_rad) {
    if (!compass_zero_rad_) compass_zero_rad_ = *tick.compass_rad - pose_.rpy(2);
    pose_.rpy(2) = wrap_angle(*tick.compass_rad - *compass_zero_rad_);
    compass_spoke_ = true;
  }
  if (tick.depth_m) pose_.translation.z() = *tick.depth_m;
  if (tick.velocity && tick.velocity->bottom_lock) {
    const Eigen::Matrix3d vehicle_R_log =
        rotation_from_rpy({velocity_log_.mount_roll_rad, velocity_log_.mount_pitch_rad, velocity_log_.mount_yaw_rad});
    const Eigen::Vector3d lever(velocity_log_.mount_forward_m, velocity_log_.mount_starboard_m, velocity_log_.mount_down_m);
    velocity_m_s_ = vehicle_R_log * tick.velocity->velocity_m_s - rates_rad_s_.cross(lever);
  }
}

}  // namespace ssjs
