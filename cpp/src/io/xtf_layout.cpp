#include "ssjs/io/xtf_layout.hpp"

#include <algorithm>

namespace ssjs {

using xtf::ChannelInfo;
using xtf::ChannelPlace;
using xtf::SampleFormat;

namespace {

constexpr std::size_t kChannelInfoBytes = 128;
constexpr std::size_t kFirstBlockInfos = 6;      ///< of channels in the first 1024 bytes
constexpr std::size_t kFurtherBlockInfos = 8;    ///< in each 1024 bytes more
constexpr std::uint64_t kFixedPacketBytes = 64;  ///< of attitude, gyro and navigation
constexpr unsigned kPort = 1, kStarboard = 2;

ChannelInfo read_channel_info(const ByteView& bytes) {
  ChannelInfo info;
  info.type = bytes.u8(0);
  info.sample_bytes = bytes.u16(6);
  info.samples = bytes.u32(8);
  info.frequency_hz = bytes.f32(32) * 1e3;
  if (!(info.frequency_hz > 0.0 && info.frequency_hz < 1e8)) info.frequency_hz = 0.0;
  const unsigned format = bytes.u8(74);
  if (format == 1 || format == 5) {
    info.format = format == 1 ? SampleFormat::kIbmFloat : SampleFormat::kIeeeFloat;
    info.sample_bytes = 4;
  }
  const bool known = info.sample_bytes == 1 || info.sample_bytes == 2 || info.sample_bytes == 4 || info.sample_bytes == 8;
  if (!known) info.sample_bytes = 0;
  return info;
}

/// Bytes up to the end of the last channel.
std::uint64_t end_of(const std::vector<ChannelPlace>& places) {
  return places.empty() ? xtf::kPingHeaderBytes : places.back().samples + places.back().sample_count * places.back().sample_bytes;
}

}  // namespace

XtfLayout::XtfLayout(ByteSource& source) {
  const ByteView first = source.view(0, xtf::kFileHeaderBytes);
  if (first.size() < xtf::kFileHeaderBytes) return;
  recorder_ = first.text(2, 8);
  sonar_ = first.text(18, 16);
  navigation_units_ = first.u16(164);
  std::size_t stated = first.u16(166);
  for (const std::size_t other : {168U, 172U}) stated += first.u16(other);
  for (const std::size_t other : {170U, 171U, 174U}) stated += first.u8(other);
  stated = std::min(std::max(stated, kFirstBlockInfos), xtf::kMaxChannels);
  const std::size_t more = (stated - kFirstBlockInfos + kFurtherBlockInfos - 1) / kFurtherBlockInfos;
  bytes_ = xtf::kFileHeaderBytes * (1 + more);

  const ByteView header = source.view(0, static_cast<std::size_t>(bytes_));
  for (std::size_t i = 0; i < stated; ++i) {
    const std::size_t offset = 256 + i * kChannelInfoBytes;
    if (!header.holds(offset, kChannelInfoBytes)) break;
    channels_.push_back(read_channel_info(header.part(offset, kChannelInfoBytes)));
    knows_side_scan_ = knows_side_scan_ || channels_.back().type == kPort || channels_.back().type == kStarboard;
  }
}

std::optional<ChannelInfo> XtfLayout::info_of(unsigned number, std::size_t position) const {
  if (!knows_side_scan_) return std::nullopt;
  if (number < channels_.size() && channels_[number].sample_bytes > 0) return channels_[number];
  if (position < channels_.size() && channels_[position].sample_bytes > 0) return channels_[position];
  return std::nullopt;
}

std::vector<ChannelPlace> XtfLayout::places(ByteSource& source, std::uint64_t offset, std::uint64_t length,
                                            std::size_t unknown_sample_bytes) const {
  std::vector<ChannelPlace> found;
  const ByteView ping = source.view(offset, xtf::kPacketHeaderBytes);
  if (ping.size() < xtf::kPacketHeaderBytes) return found;
  const std::size_t count = std::min<std::size_t>(ping.u16(4), xtf::kMaxChannels);
  std::uint64_t at = xtf::kPingHeaderBytes;
  for (std::size_t i = 0; i < count && at + xtf::kChannelHeaderBytes <= length; ++i) {
    const ByteView header = source.view(offset + at, xtf::kChannelHeaderBytes);
    if (header.size() < xtf::kChannelHeaderBytes) break;
    ChannelPlace place;
    place.number = header.u16(0);
    place.info = info_of(place.number, i);
    place.header = static_cast<std::size_t>(at);
    place.samples = place.header + xtf::kChannelHeaderBytes;
    place.sample_bytes = place.info ? place.info->sample_bytes : unknown_sample_bytes;
    const std::uint32_t in_ping = header.u32(42);
    place.sample_count = in_ping > 0 || !place.info ? in_ping : place.info->samples;
    if (place.sample_count > (length - place.samples) / place.sample_bytes) break;
    at = place.samples + place.sample_count * place.sample_bytes;
    found.push_back(place);
  }
  return found;
}

std::vector<ChannelPlace> XtfLayout::channels(ByteSource& source, std::uint64_t offset, std::uint64_t length) const {
  std::vector<ChannelPlace> best = places(source, offset, length, 2);
  if (knows_side_scan_) return best;
  // Without the file header: the sample size with which the channels fill the packet.
  for (const std::size_t sample_bytes : {1U, 4U}) {
    std::vector<ChannelPlace> other = places(source, offset, length, sample_bytes);
    if (other.size() > best.size() || (other.size() == best.size() && end_of(other) > end_of(best))) best = std::move(other);
  }
  return best;
}

PacketContent XtfLayout::content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const {
  const ByteView header = source.view(offset, xtf::kPacketHeaderBytes);
  if (header.size() < xtf::kPacketHeaderBytes) return {false, false, 0};
  const unsigned type = header.u8(2);
  const std::size_t stated = header.u16(4);
  if (type != xtf::kSonar) {
    const bool fixed = type == xtf::kAttitude || type == xtf::kGyro || type == xtf::kSourceTimeGyro || type == xtf::kNavigation ||
                       type == xtf::kRawNavigation;
    return {!fixed || length >= kFixedPacketBytes, false, fixed ? kFixedPacketBytes : 0};
  }
  if (length < xtf::kPingHeaderBytes || stated > xtf::kMaxChannels) return {false, false, 0};
  const std::vector<ChannelPlace> found = channels(source, offset, length);
  const std::uint64_t used = end_of(found);
  const bool complete = found.size() == stated && stated > 0;
  return {!found.empty() || stated == 0, complete && length - used < xtf::kChannelHeaderBytes, used};
}

}  // namespace ssjs
