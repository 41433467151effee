#include "ssjs/io/xtf_navigation.hpp"

#include "ssjs/io/log_clock.hpp"
#include "ssjs/io/ping_fields.hpp"
#include "ssjs/io/xtf_layout.hpp"

namespace ssjs::xtf {
namespace {

constexpr unsigned kUnitsMetres = 0, kUnitsDegrees = 3;
constexpr double kPerDecimetre_m = 0.1;
constexpr double kDeepest_m = 12000.0;

RecordedPosition position_from(double y, double x, unsigned navigation_units) {
  RecordedPosition position;
  if (y == 0.0 && x == 0.0) return position;
  const bool in_metres = navigation_units == kUnitsMetres || (navigation_units != kUnitsDegrees && !is_geographic(y, x));
  if (in_metres && std::abs(x) < 1e8 && std::abs(y) < 1e8) {
    position.kind = RecordedPosition::Kind::kMetres;
    position.north_m = y;
    position.east_m = x;
    position.is_doubtful = std::abs(x) <= 180.0 && std::abs(y) <= 90.0 && x != std::floor(x) && y != std::floor(y);
  } else if (!in_metres && is_geographic(y, x)) {
    position.kind = RecordedPosition::Kind::kDegrees;
    position.latitude_deg = y;
    position.longitude_deg = x;
  } else {
    position.kind = RecordedPosition::Kind::kImpossible;
  }
  return position;
}

/// Date and time at bytes 14 to 20 of a packet.
std::optional<double> packet_time(const ByteView& bytes) {
  return utc_seconds(bytes.u16(14), bytes.u8(16), bytes.u8(17), bytes.u8(18), bytes.u8(19), bytes.u8(20));
}

/// Packet 107: the date, and tenths of milliseconds at byte 21, whatever the field is called.
std::optional<double> raw_time(const ByteView& bytes) {
  std::optional<double> time_s = packet_time(bytes);
  if (time_s && bytes.u16(21) < 10000) *time_s += bytes.u16(21) * 1e-4;
  return time_s;
}

/// Header navigation and gyro packets: the source's epoch, else the date; microseconds at byte 21.
std::optional<double> source_time(const ByteView& bytes) {
  const std::uint32_t epoch_s = bytes.u32(25);
  const std::uint32_t microseconds = bytes.u32(21);
  std::optional<double> time_s = packet_time(bytes);
  if (epoch_s != 0) time_s = epoch_s;
  if (time_s && microseconds < 1000000) *time_s += microseconds * 1e-6;
  return time_s;
}

template <class T>
T without_time(LogProblems& problems, std::uint64_t offset) {
  problems.add("a navigation record without a valid time", offset, Loss::kData);
  return std::nullopt;
}

}  // namespace

RecordedPosition recorded_position(const ByteView& ping, unsigned navigation_units) {
  RecordedPosition position = position_from(ping.f64(160), ping.f64(168), navigation_units);
  if (position.kind != RecordedPosition::Kind::kNone) {
    position.source = position.is_known() ? "sensor" : "none";
    return position;
  }
  position = position_from(ping.f64(128), ping.f64(136), navigation_units);
  position.source = position.is_known() ? "ship" : "none";
  return position;
}

void read_motion(const Packet& packet, SideScanPing& ping, SonarLogInfo& info) {
  const ByteView& bytes = packet.bytes;
  const double sensor_heading = bytes.f32(212), ship_heading = bytes.f32(124);
  const double pitch = bytes.f32(204), roll = bytes.f32(208);
  const double sensor_knots = bytes.f32(152), ship_knots = bytes.f32(120);
  const double depth = bytes.f32(192), primary = bytes.f32(196), auxiliary = bytes.f32(200);
  // Decimetres below the vessel: those of the sonar too if it sits on the vessel.
  const bool on_vessel = bytes.f32(184) == 0.0F && ((bytes.f64(160) == 0.0 && bytes.f64(168) == 0.0) ||
                                                    (bytes.f64(160) == bytes.f64(128) && bytes.f64(168) == bytes.f64(136)));
  const double ship_altitude = on_vessel ? bytes.u16(144) * kPerDecimetre_m : 0.0;
  const double ship_depth = on_vessel ? bytes.u16(146) * kPerDecimetre_m : 0.0;

  const bool nothing = sensor_heading == 0.0 && ship_heading == 0.0 && pitch == 0.0 && roll == 0.0 && sensor_knots == 0.0 &&
                       ship_knots == 0.0 && depth == 0.0 && primary == 0.0 && auxiliary == 0.0 && ship_altitude == 0.0 && ship_depth == 0.0;
  if (!nothing) {
    ping.heading_rad = heading_from_degrees(sensor_heading != 0.0 ? sensor_heading : ship_heading);
    ping.pitch_rad = tilt_from_degrees(pitch);
    ping.roll_rad = tilt_from_degrees(roll);
    ping.speed_m_s = value_within(sensor_knots != 0.0 ? sensor_knots : ship_knots, 0.0, 100.0) * kPerKnot_m_s;
    ping.depth_m = value_within(depth != 0.0 ? depth : ship_depth, -100.0, kDeepest_m);
  }
  const auto use_altitude = [&](double altitude_m, const char* source) {
    if (!(altitude_m > 0.0 && altitude_m < kDeepest_m)) return false;
    ping.altitude_m = altitude_m;
    info.altitude_source.count(source);
    return true;
  };
  if (!use_altitude(primary, "primary (bottom track)") && !use_altitude(auxiliary, "auxiliary (altimeter)") &&
      !use_altitude(ship_altitude, "ship"))
    info.altitude_source.count("none");
}

std::optional<SonarRecord> position_record(const Packet& packet, unsigned navigation_units, LogProblems& problems) {
  const ByteView& bytes = packet.bytes;
  const bool raw = bytes.u8(2) == kRawNavigation;
  const std::optional<double> time_s = raw ? raw_time(bytes) : source_time(bytes);
  if (!time_s) return without_time<std::optional<SonarRecord>>(problems, packet.offset);
  const RecordedPosition position = position_from(bytes.f64(raw ? 23 : 33), bytes.f64(raw ? 31 : 41), navigation_units);
  if (!position.is_known()) {
    problems.add("a navigation record without a position", packet.offset, Loss::kNothing);
    return std::nullopt;
  }
  return PositionRecord{*time_s, position.latitude_deg, position.longitude_deg, position.east_m, position.north_m};
}

std::optional<SonarRecord> raw_attitude_record(const Packet& packet) {
  const ByteView& bytes = packet.bytes;
  const double pitch = bytes.f32(47), roll = bytes.f32(51), heading = bytes.f32(59);
  const std::optional<double> time_s = raw_time(bytes);
  if (!time_s || (pitch == 0.0 && roll == 0.0 && heading == 0.0)) return std::nullopt;
  return AttitudeRecord{*time_s, tilt_from_degrees(roll), tilt_from_degrees(pitch), heading_from_degrees(heading)};
}

std::optional<SonarRecord> attitude_record(const Packet& packet, LogProblems& problems) {
  const ByteView& bytes = packet.bytes;
  std::optional<double> time_s = utc_seconds(bytes.u16(54), bytes.u8(56), bytes.u8(57), bytes.u8(58), bytes.u8(59), bytes.u8(60));
  if (bytes.u32(26) != 0) {
    time_s = bytes.u32(26) + (bytes.u32(22) < 1000000 ? bytes.u32(22) * 1e-6 : 0.0);
  } else if (time_s && bytes.u16(61) < 1000) {
    *time_s += bytes.u16(61) * 1e-3;
  }
  if (!time_s) return without_time<std::optional<SonarRecord>>(problems, packet.offset);
  return AttitudeRecord{*time_s, tilt_from_degrees(bytes.f32(34)), tilt_from_degrees(bytes.f32(30)), heading_from_degrees(bytes.f32(50))};
}

std::optional<SonarRecord> gyro_record(const Packet& packet, LogProblems& problems) {
  const std::optional<double> time_s = source_time(packet.bytes);
  if (!time_s) return without_time<std::optional<SonarRecord>>(problems, packet.offset);
  return AttitudeRecord{*time_s, SideScanPing::kUnknown, SideScanPing::kUnknown, heading_from_degrees(packet.bytes.f32(33))};
}

}  // namespace ssjs::xtf
