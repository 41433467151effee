/// One ping of a side-scan sonar with the navigation recorded beside it: what readers, the simulator and the survey share.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "ssjs/base/sonar_side.hpp"

namespace ssjs {

/// Echo strengths of one transducer, always nearest first, whatever the order in the log. Sample i was recorded at the slant range
/// (first_sample_s + i * sample_interval_s) * sound_speed / 2.
struct SideScanChannel {
  SonarSide side = SonarSide::kPort;
  double frequency_hz = 0.0;  ///< 0 where unknown
  double first_sample_s = 0.0;
  double sample_interval_s = 0.0;
  std::vector<float> samples;  ///< linear echo strength, any unit; the weighting of the log is taken out
};

/// A field the log does not give is NaN. Angles in rad, x forward, y starboard, z down; heading from true north, clockwise, [0, 2 pi).
struct SideScanPing {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  double time_s = kUnknown;                                  ///< UTC, seconds since 1970
  std::uint32_t number = 0;                                  ///< as counted by the sonar
  double latitude_deg = kUnknown, longitude_deg = kUnknown;  ///< WGS84, of the sonar itself (layback applied)
  double east_m = kUnknown, north_m = kUnknown;              ///< of the sonar where the log has projected coordinates instead
  double position_time_s = kUnknown;                         ///< UTC at which the position was measured: pings repeat the last fix
  double heading_rad = kUnknown, roll_rad = kUnknown, pitch_rad = kUnknown;
  double speed_m_s = kUnknown;
  double depth_m = kUnknown;     ///< below the surface
  double altitude_m = kUnknown;  ///< above the bottom
  double sound_speed_m_s = kUnknown;
  std::vector<SideScanChannel> channels;
};

}  // namespace ssjs
