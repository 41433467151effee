#include "ssjs/io/jsf_fields.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ssjs/io/log_clock.hpp"
#include "ssjs/io/ping_fields.hpp"

namespace ssjs::jsf {
namespace {

constexpr double kSecondsPerDay = 86400.0;
constexpr double kPerTiltUnit_deg = 180.0 / 32768.0;
constexpr double kDeepest_m = 12000.0;
constexpr std::int16_t kNoVelocity = std::numeric_limits<std::int16_t>::min();

enum Validity : unsigned { kPosition = 0, kSpeed = 2, kHeading = 3, kTilt = 5, kAltitude = 6, kDepth = 9 };

/// Older recorders leave all of the bits zero: then what is not zero counts.
bool is_valid(const ByteView& trace, Validity bit, bool is_zero) {
  const unsigned flags = trace.u16(30);
  return flags == 0 ? !is_zero : ((flags >> bit) & 1U) != 0;
}

double trace_time(const ByteView& trace) {
  const double second = trace.u32(0);
  const std::uint32_t today_ms = trace.u32(200);
  if (second > 0.0) {
    const double exact = std::floor(second / kSecondsPerDay) * kSecondsPerDay + today_ms * 1e-3;
    return std::abs(exact - second) < 1.5 ? exact : second + (today_ms % 1000) * 1e-3;
  }
  const auto new_year = utc_seconds(trace.i16(156), 1, 1, trace.i16(160), trace.i16(162), trace.i16(164));
  const int day = trace.i16(158);
  return new_year && day >= 1 && day <= 366 ? *new_year + (day - 1) * kSecondsPerDay + (today_ms % 1000) * 1e-3 : SideScanPing::kUnknown;
}

double message_time(const ByteView& message) { return message.u32(0) + (message.u32(4) % 1000) * 1e-3; }

bool has(std::uint32_t flags, unsigned bit) { return ((flags >> bit) & 1U) != 0; }

void append_velocity(const ByteView& message, std::vector<SonarRecord>& records) {
  const double time_s = message_time(message);
  const std::uint32_t flags = message.u32(12);
  VelocityRecord velocity{time_s};
  const std::int16_t x = message.i16(32), y = message.i16(34), z = message.i16(36);
  // Velocities over ground along the axes of the ship; those along east and north are left out.
  velocity.bottom_lock = has(flags, 0) && has(flags, 1) && !has(flags, 31) && x != kNoVelocity && y != kNoVelocity;
  if (velocity.bottom_lock) {
    velocity.starboard_m_s = x * 1e-3;
    velocity.forward_m_s = y * 1e-3;
    if (has(flags, 2) && z != kNoVelocity) velocity.down_m_s = -z * 1e-3;
  }
  records.emplace_back(velocity);

  double sum_m = 0.0;
  int beams = 0;
  for (std::size_t beam = 0; beam < 4; ++beam) {
    const std::int32_t range_cm = message.i32(16 + 4 * beam);
    if (range_cm <= 0) continue;
    sum_m += range_cm * 0.01;
    ++beams;
  }
  if (has(flags, 5) && beams > 0) records.emplace_back(AltitudeRecord{time_s, sum_m / beams});
  if (has(flags, 10)) records.emplace_back(DepthRecord{time_s, message.u16(44) * 0.1});
  if (!has(flags, 6) && !has(flags, 7) && !has(flags, 8)) return;
  AttitudeRecord attitude{time_s};
  if (has(flags, 8)) attitude.roll_rad = tilt_from_degrees(message.i16(48) * 0.01);
  if (has(flags, 7)) attitude.pitch_rad = tilt_from_degrees(message.i16(46) * 0.01);
  if (has(flags, 6)) attitude.heading_rad = heading_from_degrees(message.u16(50) * 0.01);
  records.emplace_back(attitude);
}

}  // namespace

TraceSamples trace_samples(const ByteView& trace) {
  TraceSamples samples;
  samples.count = trace.u16(114) | (static_cast<std::size_t>((trace.u16(16) >> 8U) & 0xFU) << 16U);
  switch (trace.i16(34)) {
    case 0:
    case 4:
      return {samples.count, 2, SampleKind::kUnsigned};
    case 1:
      return {samples.count, 4, SampleKind::kComplex};
    case 2:
    case 3:
      return {samples.count, 2, SampleKind::kMagnitude};
    default:
      return samples;
  }
}

void read_trace_navigation(const ByteView& trace, std::uint64_t offset, SideScanPing& ping, SonarLogInfo& info) {
  ping.number = trace.u32(8);
  ping.time_s = trace_time(trace);
  info.time_source.count(std::isfinite(ping.time_s) ? "seconds and milliseconds of the day" : "none");
  if (!std::isfinite(ping.time_s)) info.problems.add("a ping without a valid time", offset, Loss::kNothing);

  const std::uint16_t heading = trace.u16(172);
  const std::int16_t pitch = trace.i16(174), roll = trace.i16(176), speed = trace.i16(194);
  const std::int32_t depth_mm = trace.i32(136), altitude_mm = trace.i32(144);
  if (is_valid(trace, kHeading, heading == 0)) ping.heading_rad = heading_from_degrees(heading * 0.01);
  if (is_valid(trace, kTilt, pitch == 0 && roll == 0)) {
    ping.pitch_rad = tilt_from_degrees(pitch * kPerTiltUnit_deg);
    ping.roll_rad = tilt_from_degrees(roll * kPerTiltUnit_deg);
  }
  if (is_valid(trace, kSpeed, speed == 0)) ping.speed_m_s = value_within(speed * 0.1, 0.0, 100.0) * kPerKnot_m_s;
  if (is_valid(trace, kDepth, depth_mm == 0)) ping.depth_m = value_within(depth_mm * 1e-3, -100.0, kDeepest_m);
  const bool with_altitude = is_valid(trace, kAltitude, altitude_mm == 0) && altitude_mm > 0 && altitude_mm * 1e-3 < kDeepest_m;
  if (with_altitude) ping.altitude_m = altitude_mm * 1e-3;
  info.altitude_source.count(with_altitude ? "trace header" : "none");

  const SoundSpeed sound = sound_speed_of(trace.f32(148), SideScanPing::kUnknown, SideScanPing::kUnknown, SideScanPing::kUnknown);
  ping.sound_speed_m_s = sound.speed_m_s;
  info.sound_speed_source.count(sound.source);
}

void read_trace_position(const ByteView& trace, std::uint64_t offset, SideScanPing& ping, SonarLogInfo& info) {
  const std::int32_t x = trace.i32(80), y = trace.i32(84);
  const int units = trace.i16(88);
  const bool given = is_valid(trace, kPosition, x == 0 && y == 0) && (x != 0 || y != 0);
  const double metres = units == 1 ? 1e-3 : units == 3 ? 0.1 : units == 4 ? 0.01 : 0.0;
  if (given && units == 2 && is_geographic(y / 600000.0, x / 600000.0)) {
    ping.latitude_deg = y / 600000.0;  // ten-thousandths of a minute of arc
    ping.longitude_deg = x / 600000.0;
  } else if (given && metres > 0.0) {
    ping.east_m = x * metres;
    ping.north_m = y * metres;
  } else if (given) {
    info.problems.add("a position that is none on the globe", offset, Loss::kNothing);
  } else {
    info.problems.add("a ping without a position (its navigation is all zero)", offset, Loss::kNothing);
  }
  const bool known = std::isfinite(ping.latitude_deg) || std::isfinite(ping.east_m);
  info.position_source.count(known ? "trace header" : "none");
}

void append_navigation(unsigned type, const ByteView& message, std::vector<SonarRecord>& records) {
  if (type == kDopplerVelocity) return append_velocity(message, records);
  const double time_s = message_time(message);
  if (type == kPressure) {
    const std::int32_t depth_m = message.i32(36);
    if (has(message.u32(24), 5)) records.emplace_back(DepthRecord{time_s, value_within(depth_m, -100.0, kDeepest_m)});
    return;
  }
  const std::uint32_t flags = message.u32(36);
  AttitudeRecord attitude{time_s};
  if (has(flags, 6)) attitude.pitch_rad = tilt_from_degrees(message.i16(24) * kPerTiltUnit_deg);
  if (has(flags, 7)) attitude.roll_rad = tilt_from_degrees(message.i16(26) * kPerTiltUnit_deg);
  if (has(flags, 9)) attitude.heading_rad = heading_from_degrees(message.u16(34) * 0.01);
  if (has(flags, 6) || has(flags, 7) || has(flags, 9)) records.emplace_back(attitude);
}

}  // namespace ssjs::jsf
