#include "ssjs/io/packet_framing.hpp"

#include <algorithm>
#include <cstring>

namespace ssjs {
namespace {

constexpr std::size_t kMagicBytes = 2;
constexpr std::size_t kSearchBytes = 64 * 1024;
/// Room behind the fields of a packet in which another packet may hide because the length is wrong; writers pad to 64 bytes.
constexpr std::uint64_t kSuspiciousSlackBytes = 256;

}  // namespace

bool PacketReader::starts_at(std::uint64_t offset) const {
  const ByteView start = source_.view(offset, kMagicBytes);
  return start.size() == kMagicBytes && start.u16(0) == grammar_.magic();
}

std::uint64_t PacketReader::length_at(std::uint64_t offset) const {
  const ByteView header = source_.view(offset, grammar_.header_bytes());
  if (header.size() < grammar_.header_bytes() || header.u16(0) != grammar_.magic()) return 0;
  const std::uint64_t length = grammar_.length(header);
  return length < grammar_.header_bytes() ? 0 : length;
}

std::optional<Packet> PacketReader::next() {
  while (offset_ < source_.size()) {
    const std::uint64_t left = source_.size() - offset_;
    if (left < grammar_.header_bytes() && (left < kMagicBytes || starts_at(offset_))) {
      problems_.add("the log ends within a packet; what it held is lost", offset_, Loss::kData);
      bytes_skipped_ += left;
      offset_ = source_.size();
      break;
    }
    if (!starts_at(offset_)) {
      resume(offset_, offset_ + 1, "bytes that are no packet; reading goes on at the next one",
             "bytes that are no packet at the end of the log");
      continue;
    }
    const std::uint64_t length = length_at(offset_);
    if (length == 0) {
      resume(offset_, offset_ + kMagicBytes, "a packet of length zero or shorter than its header",
             "a packet of length zero or shorter than its header");
      continue;
    }
    if (length > left) {
      resume(offset_, offset_ + kMagicBytes, "a packet whose length leads beyond the end of the log",
             "the log ends within a packet; what it held is lost");
      continue;
    }
    const PacketContent content = length <= max_packet_bytes_ ? grammar_.content(source_, offset_, length) : PacketContent{false, false, 0};
    if (!content.possible) {
      const char* what =
          length > max_packet_bytes_ ? "a packet longer than any is allowed to be" : "a packet whose fields contradict its length";
      if (is_followed(offset_ + length)) {
        problems_.add(what, offset_, Loss::kData);
        leave({true, false, grammar_.header_bytes()}, length);
      } else {
        resume(offset_, offset_ + kMagicBytes, what, what);
      }
      continue;
    }
    const std::uint64_t start = offset_;
    leave(content, length);
    const ByteView bytes = source_.view(start, static_cast<std::size_t>(length));
    if (bytes.size() == length) return Packet{start, bytes};
    offset_ = source_.size();  // the file shrank while it was read
    problems_.add("the log ends within a packet; what it held is lost", start, Loss::kData);
  }
  return std::nullopt;
}

void PacketReader::leave(const PacketContent& content, std::uint64_t length) {
  const std::uint64_t end = offset_ + length;
  if (is_followed(end)) {
    const bool suspicious = !content.exact && content.used > 0 && length - content.used >= kSuspiciousSlackBytes;
    const std::optional<std::uint64_t> hidden = suspicious ? find(offset_ + content.used, end) : std::nullopt;
    if (hidden) problems_.add("a packet longer than its content; the packets within are read", offset_, Loss::kNothing);
    offset_ = hidden.value_or(end);
    return;
  }
  // The length may be wrong: what this packet does not account for is searched.
  const std::uint64_t used = content.used > 0 ? content.used : grammar_.header_bytes();
  resume(offset_ + used, offset_ + used, "bytes that are no packet; reading goes on at the next one",
         "bytes that are no packet at the end of the log");
}

void PacketReader::resume(std::uint64_t place, std::uint64_t from, const char* what, const char* what_at_end) {
  const std::optional<std::uint64_t> found = find(from, source_.size());
  problems_.add(found ? what : what_at_end, place, Loss::kData);
  const std::uint64_t next = found.value_or(source_.size());
  bytes_skipped_ += next - from;
  offset_ = next;
}

std::optional<std::uint64_t> PacketReader::find(std::uint64_t from, std::uint64_t before) const {
  const auto first = static_cast<unsigned char>(grammar_.magic() & 0xFFU);
  std::uint64_t offset = from;
  while (offset < before) {
    const ByteView block = source_.view(offset, static_cast<std::size_t>(std::min<std::uint64_t>(kSearchBytes, before - offset)));
    if (block.size() == 0) return std::nullopt;
    const void* hit = std::memchr(block.data(), first, block.size());
    if (hit == nullptr) {
      offset += block.size();
      continue;
    }
    offset += static_cast<std::uint64_t>(static_cast<const unsigned char*>(hit) - block.data());
    const std::uint64_t length = starts_at(offset) ? length_at(offset) : 0;
    if (length > 0 && length <= max_packet_bytes_ && length <= source_.size() - offset) {
      const PacketContent content = grammar_.content(source_, offset, length);
      if (content.possible && (content.exact || is_followed(offset + length))) return offset;
    }
    ++offset;
  }
  return std::nullopt;
}

}  // namespace ssjs
