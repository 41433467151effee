#include "ssjs/features/navigation_tick.hpp"

namespace ssjs {

bool share_a_sensor(const NavigationTick& a, const NavigationTick& b) {
  return (a.gyro_rad_s && b.gyro_rad_s) || (a.roll_pitch_rad && b.roll_pitch_rad) || (a.compass_rad && b.compass_rad) ||
         (a.depth_m && b.depth_m) || (a.altitude_m && b.altitude_m) || (a.velocity && b.velocity) || (a.fix && b.fix) ||
         (a.frame && b.frame);
}

void take_in(NavigationTick& tick, const NavigationTick& more) {
  const auto take = [](auto& mine, const auto& other) {
    if (other) mine = other;
  };
  take(tick.gyro_rad_s, more.gyro_rad_s);
  take(tick.roll_pitch_rad, more.roll_pitch_rad);
  take(tick.compass_rad, more.compass_rad);
  take(tick.depth_m, more.depth_m);
  take(tick.altitude_m, more.altitude_m);
  take(tick.velocity, more.velocity);
  take(tick.fix, more.fix);
  take(tick.frame, more.frame);
  tick.sightings.insert(tick.sightings.end(), more.sightings.begin(), more.sightings.end());
}

}  // namespace ssjs
