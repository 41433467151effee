/// All samples that an underwater vehicle took at one time, of whichever sensors spoke.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/base/archive.hpp"
#include "ssjs/sensors/camera_frame.hpp"
#include "ssjs/sensors/navigation_sensors.hpp"
#include "ssjs/sensors/position_fix.hpp"
#include "ssjs/sensors/side_scan.hpp"

namespace ssjs {

/// Sensors are asynchronous: a tick may hold a single sample, and ticks come at any times that do not decrease.
struct NavigationTick {
  double time_s = 0.0;
  std::optional<Eigen::Vector3d> gyro_rad_s;  ///< body rates; hold from this time until the next gyro sample
  std::optional<Eigen::Vector2d> roll_pitch_rad;
  std::optional<double> compass_rad;
  std::optional<double> depth_m;
  std::optional<double> altitude_m;
  std::optional<VelocitySample> velocity;
  std::optional<PositionFix> fix;
  SideScanSightings sightings;
  std::optional<CameraFrame> frame;  ///< its sightings in the pixels of the corrected frame

  void archive(Archive& a) {
    a("time_s", time_s);
    a("gyro_rad_s", gyro_rad_s);
    a("roll_pitch_rad", roll_pitch_rad);
    a("compass_rad", compass_rad);
    a("depth_m", depth_m);
    a("altitude_m", altitude_m);
    a("velocity", velocity);
    a("fix", fix);
    a("sightings", sightings);
    a("frame", frame);
  }
};

[[nodiscard]] inline NavigationTick tick_at(double time_s) {
  NavigationTick tick;
  tick.time_s = time_s;
  return tick;
}

/// Whether a sensor speaks in both; sightings are any number.
[[nodiscard]] bool share_a_sensor(const NavigationTick& a, const NavigationTick& b);

/// Everything that `more` holds comes into `tick`, in the place of what the same sensor said before.
void take_in(NavigationTick& tick, const NavigationTick& more);

}  // namespace ssjs
