#include "ssjs/io/jsf.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/io/jsf_fields.hpp"
#include "ssjs/io/ping_fields.hpp"
#include "ssjs/io/sample_decoding.hpp"
#include "ssjs/io/towed_position.hpp"

namespace ssjs {
namespace {

constexpr unsigned kFirstSideScan = 20, kLastSideScan = 22;  ///< subsystems of low, high and very high frequency

bool is_side_scan(const Packet& packet) {
  const unsigned subsystem = packet.bytes.u8(7);
  return packet.bytes.u16(4) == jsf::kTrace && subsystem >= kFirstSideScan && subsystem <= kLastSideScan && packet.bytes.u8(8) < 2;
}

ByteView body_of(const Packet& packet) {
  return packet.bytes.part(jsf::kMessageHeaderBytes, packet.bytes.size() - jsf::kMessageHeaderBytes);
}

/// The shortest body of a message that is decoded.
std::size_t least_body_bytes(unsigned type) {
  switch (type) {
    case jsf::kTrace:
      return jsf::kTraceHeaderBytes;
    case jsf::kPitchRoll:
    case jsf::kPressure:
      return 40;
    case jsf::kDopplerVelocity:
      return 52;
    default:
      return 0;
  }
}

}  // namespace

bool looks_like_jsf(ByteSource& source) {
  const ByteView start = source.view(0, 2);
  return start.size() == 2 && start.u16(0) == JsfGrammar().magic();
}

std::uint64_t JsfGrammar::length(const ByteView& header) const {
  const std::int32_t body = header.i32(12);
  return body < 0 ? 0 : jsf::kMessageHeaderBytes + static_cast<std::uint64_t>(body);
}

PacketContent JsfGrammar::content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const {
  const ByteView header = source.view(offset, jsf::kMessageHeaderBytes);
  if (header.size() < jsf::kMessageHeaderBytes) return {false, false, 0};
  const unsigned type = header.u16(4);
  const std::uint64_t body = length - jsf::kMessageHeaderBytes;
  if (body < least_body_bytes(type)) return {false, false, 0};
  if (type != jsf::kTrace) return {true, false, 0};
  const ByteView trace = source.view(offset + jsf::kMessageHeaderBytes, jsf::kTraceHeaderBytes);
  if (trace.size() < jsf::kTraceHeaderBytes) return {false, false, 0};
  const jsf::TraceSamples samples = jsf::trace_samples(trace);
  if (samples.sample_bytes == 0) return {true, false, 0};
  const std::uint64_t used = jsf::kMessageHeaderBytes + jsf::kTraceHeaderBytes + samples.count * samples.sample_bytes;
  return {used <= length, used == length, used};
}

JsfReader::JsfReader(std::unique_ptr<ByteSource> source, const SonarLogConfig& config)
    : source_(std::move(source)), config_(config), packets_(*source_, grammar_, info_.problems, 0, config.max_packet_bytes) {
  info_.format = "jsf";
  info_.recorder = "EdgeTech";
}

std::optional<SonarRecord> JsfReader::next() {
  while (taken_ == ready_.size()) {
    ready_.clear();
    taken_ = 0;
    const std::optional<Packet> packet = packets_.next();
    info_.bytes_skipped = packets_.bytes_skipped();
    if (packet) {
      decode(*packet);
    } else if (unfinished_.empty()) {
      return std::nullopt;
    } else {
      finish(unfinished_.begin()->first);
    }
  }
  return std::move(ready_[taken_++]);
}

void JsfReader::decode(const Packet& packet) {
  const unsigned type = packet.bytes.u16(4);
  ++info_.packet_types[type];
  if (is_side_scan(packet)) return add_trace(packet);
  if (type == jsf::kPitchRoll || type == jsf::kPressure || type == jsf::kDopplerVelocity)
    jsf::append_navigation(type, body_of(packet), ready_);
}

void JsfReader::add_trace(const Packet& packet) {
  std::optional<SideScanChannel> channel = channel_of(packet);
  if (!channel) return;
  const unsigned subsystem = packet.bytes.u8(7);
  const std::uint32_t number = body_of(packet).u32(8);
  auto waiting = unfinished_.find(subsystem);
  if (waiting != unfinished_.end()) {
    const SideScanPing& other = waiting->second;
    if (other.number != number || other.channels.front().side == channel->side) {
      info_.problems.add("a ping with one side only", packet.offset, Loss::kNothing);
      finish(subsystem);
      waiting = unfinished_.end();
    }
  }
  if (waiting == unfinished_.end()) {
    waiting = unfinished_.emplace(subsystem, ping_of(packet)).first;
    waiting->second.channels.push_back(std::move(*channel));
    return;
  }
  waiting->second.channels.push_back(std::move(*channel));
  finish(subsystem);
}

void JsfReader::finish(unsigned subsystem) {
  auto finished = unfinished_.extract(subsystem);
  std::vector<SideScanChannel>& channels = finished.mapped().channels;
  std::sort(channels.begin(), channels.end(), [](const SideScanChannel& a, const SideScanChannel& b) { return a.side < b.side; });
  ++info_.pings;
  ready_.emplace_back(std::move(finished.mapped()));
}

SideScanPing JsfReader::ping_of(const Packet& packet) {
  const ByteView trace = body_of(packet);
  SideScanPing ping;
  jsf::read_trace_navigation(trace, packet.offset, ping, info_);
  jsf::read_trace_position(trace, packet.offset, ping, info_);
  const double x = std::isfinite(ping.longitude_deg) ? ping.longitude_deg : ping.east_m;
  const double y = std::isfinite(ping.latitude_deg) ? ping.latitude_deg : ping.north_m;
  if (x == last_x_ && y == last_y_) ++info_.repeated_positions;
  last_x_ = x;
  last_y_ = y;

  const double layback_m = value_within(trace.f32(228), -20000.0, 20000.0);
  const bool recorded = std::isfinite(layback_m) && layback_m != 0.0;
  const bool applied = recorded && config_.layback == LaybackMode::kApply;
  if (applied) apply_layback(ping, layback_m);
  if (std::isfinite(x)) info_.layback_mode.count(applied ? "applied" : recorded ? "taken as applied by the recorder" : "none recorded");
  return ping;
}

std::optional<SideScanChannel> JsfReader::channel_of(const Packet& packet) {
  const ByteView trace = body_of(packet);
  const jsf::TraceSamples stored = jsf::trace_samples(trace);
  const std::size_t bytes = stored.count * stored.sample_bytes;
  if (stored.sample_bytes == 0 || stored.count == 0 || stored.count > config_.max_channel_samples || trace.u16(220) > 1 ||
      !trace.holds(jsf::kTraceHeaderBytes, bytes)) {
    info_.problems.add(stored.sample_bytes == 0 ? "a trace in an unknown data format"
                       : stored.count == 0      ? "a ping without side-scan samples"
                       : trace.u16(220) > 1     ? "a continued trace (packet number above 1), left out"
                                                : "channels that do not fit into their ping",
                       packet.offset, Loss::kData);
    return std::nullopt;
  }
  SideScanChannel channel;
  channel.side = packet.bytes.u8(8) == 0 ? SonarSide::kPort : SonarSide::kStarboard;
  const unsigned high_bits = trace.u16(16);
  const double start = trace.u16(126) + 65536.0 * (high_bits & 0xFU);
  const double end = trace.u16(128) + 65536.0 * ((high_bits >> 4U) & 0xFU);
  channel.frequency_hz = 5.0 * (start + end);  // each in 10 Hz
  channel.sample_interval_s = trace.u32(116) * 1e-9;
  channel.first_sample_s = trace.u32(4) * channel.sample_interval_s;
  if (channel.sample_interval_s == 0.0) info_.problems.add("a channel without a slant range", packet.offset, Loss::kNothing);

  int weight = trace.i16(168);
  if (std::abs(weight) > kMaxWeight) {
    info_.problems.add("a weight of samples beyond 2^40, taken as none", packet.offset, Loss::kNothing);
    weight = 0;
  }
  DecodedSamples decoded =
      decode_samples(trace.part(jsf::kTraceHeaderBytes, bytes), stored.count, stored.sample_bytes, stored.kind, weight);
  if (!decoded.all_finite) info_.problems.add("samples that are no echo strength, taken as 0", packet.offset, Loss::kData);
  channel.samples = std::move(decoded.strength);  // stored near to far on both sides
  return channel;
}

}  // namespace ssjs
