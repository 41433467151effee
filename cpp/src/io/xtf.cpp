#include "ssjs/io/xtf.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/io/ping_fields.hpp"
#include "ssjs/io/sample_decoding.hpp"
#include "ssjs/io/towed_position.hpp"
#include "ssjs/io/xtf_navigation.hpp"

namespace ssjs {
namespace {

constexpr unsigned kFileFormat = 123;
constexpr unsigned kPortType = 1, kStarboardType = 2;

SampleKind sample_kind(const std::optional<xtf::ChannelInfo>& info) {
  if (!info || info->format == xtf::SampleFormat::kUnsigned) return SampleKind::kUnsigned;
  return info->format == xtf::SampleFormat::kIeeeFloat ? SampleKind::kIeeeFloat : SampleKind::kIbmFloat;
}

}  // namespace

bool looks_like_xtf(ByteSource& source) {
  const ByteView start = source.view(0, 1);
  if (start.size() == 1 && start.u8(0) == kFileFormat) return true;
  const ByteView packet = source.view(xtf::kFileHeaderBytes, 2);
  return packet.size() == 2 && packet.u16(0) == 0xFACE;
}

XtfReader::XtfReader(std::unique_ptr<ByteSource> source, const SonarLogConfig& config)
    : source_(std::move(source)),
      config_(config),
      layout_(*source_),
      packets_(*source_, layout_, info_.problems, std::min(layout_.bytes(), source_->size()), config.max_packet_bytes) {
  info_.format = "xtf";
  info_.recorder = layout_.recorder();
  info_.sonar = layout_.sonar();
  if (!layout_.knows_side_scan())
    info_.problems.add("the file header names no side-scan channel; sides are taken from channel numbers", 0, Loss::kNothing);
}

std::optional<SonarRecord> XtfReader::next() {
  if (waiting_) return std::exchange(waiting_, std::nullopt);
  while (const std::optional<Packet> packet = packets_.next()) {
    info_.bytes_skipped = packets_.bytes_skipped();
    ++info_.packet_types[packet->bytes.u8(2)];
    std::optional<SonarRecord> record = decode(*packet);
    if (record) return record;
  }
  info_.bytes_skipped = packets_.bytes_skipped();
  return std::nullopt;
}

std::optional<SonarRecord> XtfReader::decode(const Packet& packet) {
  switch (packet.bytes.u8(2)) {
    case xtf::kSonar:
      return decode_ping(packet);
    case xtf::kNavigation:
      return xtf::position_record(packet, layout_.navigation_units(), info_.problems);
    case xtf::kRawNavigation:
      waiting_ = xtf::raw_attitude_record(packet);
      if (auto position = xtf::position_record(packet, layout_.navigation_units(), info_.problems)) return position;
      return std::exchange(waiting_, std::nullopt);
    case xtf::kAttitude:
      return xtf::attitude_record(packet, info_.problems);
    case xtf::kGyro:
    case xtf::kSourceTimeGyro:
      return xtf::gyro_record(packet, info_.problems);
    default:
      return std::nullopt;
  }
}

std::optional<SonarRecord> XtfReader::decode_ping(const Packet& packet) {
  SideScanPing ping;
  ping.number = packet.bytes.u32(28);
  read_time(packet, ping);
  xtf::read_motion(packet, ping, info_);
  read_position(packet, ping);
  read_channels(packet, ping);
  if (ping.channels.empty()) {
    info_.problems.add("a ping without side-scan samples", packet.offset, Loss::kData);
    return std::nullopt;
  }
  ++info_.pings;
  return SonarRecord(std::move(ping));
}

void XtfReader::read_time(const Packet& packet, SideScanPing& ping) {
  const ByteView& bytes = packet.bytes;
  const auto whole = utc_seconds(bytes.u16(14), bytes.u8(16), bytes.u8(17), bytes.u8(18), bytes.u8(19), bytes.u8(20));
  if (!whole || bytes.u8(21) > 99) {
    info_.problems.add("a ping without a valid time", packet.offset, Loss::kNothing);
    info_.time_source.count("none");
    return;
  }
  ping.time_s = *whole + bytes.u8(21) * 0.01;
  const std::uint32_t counter_ms = bytes.u32(224);  // AttitudeTimeTag
  if (counter_ms != 0) ping.time_s = ping_counter_.refine(ping.time_s, counter_ms);
  info_.time_source.count(counter_ms != 0 ? "date and millisecond counter" : "date and hundredths");
}

void XtfReader::read_position(const Packet& packet, SideScanPing& ping) {
  const ByteView& bytes = packet.bytes;
  const xtf::RecordedPosition recorded = xtf::recorded_position(bytes, layout_.navigation_units());
  info_.position_source.count(recorded.source);
  if (recorded.kind == xtf::RecordedPosition::Kind::kImpossible)
    info_.problems.add("a position that is none on the globe", packet.offset, Loss::kNothing);
  if (recorded.kind == xtf::RecordedPosition::Kind::kNone)
    info_.problems.add("a ping without a position (its navigation is all zero)", packet.offset, Loss::kNothing);
  if (recorded.is_doubtful) info_.problems.add("coordinates said to be metres that look like degrees", packet.offset, Loss::kNothing);
  ping.latitude_deg = recorded.latitude_deg;
  ping.longitude_deg = recorded.longitude_deg;
  ping.east_m = recorded.east_m;
  ping.north_m = recorded.north_m;
  if (!recorded.is_known()) return;

  const bool same_degrees = ping.latitude_deg == last_latitude_deg_ && ping.longitude_deg == last_longitude_deg_;
  const bool same_metres = ping.east_m == last_east_m_ && ping.north_m == last_north_m_;
  if (same_degrees || same_metres) ++info_.repeated_positions;
  last_latitude_deg_ = ping.latitude_deg;
  last_longitude_deg_ = ping.longitude_deg;
  last_east_m_ = ping.east_m;
  last_north_m_ = ping.north_m;

  if (const auto fix = time_of_day_near(ping.time_s, bytes.u8(148), bytes.u8(149), bytes.u8(150)); fix && bytes.u8(151) <= 99) {
    const std::uint32_t counter_ms = bytes.u32(232);  // NavFixMilliseconds
    const double stamp_s = *fix + bytes.u8(151) * 0.01;
    ping.position_time_s = counter_ms != 0 ? fix_counter_.refine(stamp_s, counter_ms) : stamp_s;
  }

  const double layback_m = value_within(bytes.f32(184), -20000.0, 20000.0);
  const bool applied = std::isfinite(layback_m) && layback_m != 0.0 && config_.layback != LaybackMode::kIgnore;
  if (applied) apply_layback(ping, layback_m);
  info_.layback_mode.count(applied ? "applied" : layback_m == 0.0 ? "none recorded" : "ignored");
}

void XtfReader::read_channels(const Packet& packet, SideScanPing& ping) {
  const std::vector<xtf::ChannelPlace> places = layout_.channels(*source_, packet.offset, packet.bytes.size());
  const ByteView bytes = source_->view(packet.offset, packet.bytes.size());
  if (places.size() < bytes.u16(4)) info_.problems.add("channels that do not fit into their ping", packet.offset, Loss::kData);
  bool first = true;
  for (const xtf::ChannelPlace& place : places) {
    const bool is_side_scan = !place.info || place.info->type == kPortType || place.info->type == kStarboardType;
    if (!is_side_scan || place.sample_count == 0) continue;
    if (place.sample_count > config_.max_channel_samples) {
      info_.problems.add("a channel with more samples than allowed", packet.offset, Loss::kData);
      continue;
    }
    const ByteView header = bytes.part(place.header, xtf::kChannelHeaderBytes);
    const double range_m = value_within(header.f32(4), 0.0, 1e5);
    const double duration_s = value_within(header.f32(16), 0.0, 1e3);
    if (first) {
      const SoundSpeed sound = sound_speed_of(bytes.f32(32), bytes.f32(72), range_m, duration_s);
      ping.sound_speed_m_s = sound.speed_m_s;
      info_.sound_speed_source.count(sound.source);
      first = false;
    }
    SideScanChannel channel;
    const bool port = place.info ? place.info->type == kPortType : place.number % 2 == 0;
    channel.side = port ? SonarSide::kPort : SonarSide::kStarboard;
    channel.frequency_hz = header.u16(26) > 0 ? header.u16(26) * 1e3 : place.info ? place.info->frequency_hz : 0.0;
    const double delay_s = value_within(header.f32(12), 0.0, 1e3);
    channel.first_sample_s = std::isfinite(delay_s) ? delay_s : 0.0;
    const auto count = static_cast<double>(place.sample_count);
    channel.sample_interval_s = range_m > 0.0 ? 2.0 * range_m / ping.sound_speed_m_s / count : duration_s > 0.0 ? duration_s / count : 0.0;
    if (channel.sample_interval_s == 0.0) info_.problems.add("a channel without a slant range", packet.offset, Loss::kNothing);

    int weight = header.i16(58);
    if (std::abs(weight) > kMaxWeight) {
      info_.problems.add("a weight of samples beyond 2^40, taken as none", packet.offset, Loss::kNothing);
      weight = 0;
    }
    DecodedSamples decoded = decode_samples(bytes.part(place.samples, place.sample_count * place.sample_bytes), place.sample_count,
                                            place.sample_bytes, sample_kind(place.info), weight);
    if (!decoded.all_finite) info_.problems.add("samples that are no echo strength, taken as 0", packet.offset, Loss::kData);
    if (port) std::reverse(decoded.strength.begin(), decoded.strength.end());  // stored far to near
    channel.samples = std::move(decoded.strength);
    ping.channels.push_back(std::move(channel));
  }
}

}  // namespace ssjs
