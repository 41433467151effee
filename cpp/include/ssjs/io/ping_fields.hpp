/// Fields of a ping as logs hold them, turned into SI and checked: shared by the formats.
#pragma once

#include <cmath>
#include <string>

#include "ssjs/io/sonar_log.hpp"

namespace ssjs {

constexpr double kPerKnot_m_s = 1852.0 / 3600.0;

/// Degrees to rad in [0, 2 pi); NaN beyond [-360, 360].
[[nodiscard]] double heading_from_degrees(double degrees);
/// Degrees to rad; NaN beyond +-180.
[[nodiscard]] double tilt_from_degrees(double degrees);
/// The value where it is finite and in [low, high], NaN elsewhere.
[[nodiscard]] double value_within(double value, double low, double high);
/// Neither coordinate exactly zero at once, which loggers write where they have none; within the globe.
[[nodiscard]] bool is_geographic(double latitude_deg, double longitude_deg);

/// Where a ping's sound speed comes from; recorders write it one way or two.
struct SoundSpeed {
  double speed_m_s;
  const char* source;
};
/// Below 1000 a field holds half of it (750 for 1500). Falls back on `computed` (of a CTD), on twice range_m over duration_s, on 1500 m/s.
[[nodiscard]] SoundSpeed sound_speed_of(double field_m_s, double computed_m_s, double range_m, double duration_s);

}  // namespace ssjs
