/// Navigation in XTF packets: the fields of the ping header, and the packets that carry nothing else.
#pragma once

#include <cmath>
#include <optional>

#include "ssjs/io/packet_framing.hpp"
#include "ssjs/io/sonar_log.hpp"

namespace ssjs::xtf {

/// The position in a ping header as it stands, layback not yet applied.
struct RecordedPosition {
  enum class Kind { kNone, kDegrees, kMetres, kImpossible };
  Kind kind = Kind::kNone;
  const char* source = "none";  ///< "sensor", "ship" or "none"
  bool is_doubtful = false;     ///< metres in the range of degrees
  double latitude_deg = SideScanPing::kUnknown, longitude_deg = SideScanPing::kUnknown;
  double east_m = SideScanPing::kUnknown, north_m = SideScanPing::kUnknown;
  [[nodiscard]] bool is_known() const { return kind == Kind::kDegrees || kind == Kind::kMetres; }
};

/// The sensor's coordinates, or the ship's where those are zero. navigation_units: of the file header, 0 metres, 3 degrees; other
/// numbers are degrees where that is possible.
[[nodiscard]] RecordedPosition recorded_position(const ByteView& ping, unsigned navigation_units);

/// Heading, roll, pitch, speed, depth and altitude of a ping header, and where the altitude comes from.
void read_motion(const Packet& packet, SideScanPing& ping, SonarLogInfo& info);

/// Packets 42 and 107; none without a time or a position.
[[nodiscard]] std::optional<SonarRecord> position_record(const Packet& packet, unsigned navigation_units, LogProblems& problems);
/// The attitude in packet 107; none without a time or where all of it is zero.
[[nodiscard]] std::optional<SonarRecord> raw_attitude_record(const Packet& packet);
/// Packet 3; none without a time.
[[nodiscard]] std::optional<SonarRecord> attitude_record(const Packet& packet, LogProblems& problems);
/// Packets 23 and 84: heading alone.
[[nodiscard]] std::optional<SonarRecord> gyro_record(const Packet& packet, LogProblems& problems);

}  // namespace ssjs::xtf
