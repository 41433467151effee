/// The packets of a log one after the other, found again after damage. Shared by the formats whose packets start with two fixed
/// bytes and say their own length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "ssjs/io/byte_source.hpp"
#include "ssjs/io/log_problems.hpp"

namespace ssjs {

/// What the fields of a packet say about its length.
struct PacketContent {
  bool possible = true;    ///< false where they contradict the length that the header states
  bool exact = false;      ///< they account for every byte but the padding: this is a packet whatever comes behind it
  std::uint64_t used = 0;  ///< bytes that they account for, from the start of the packet
};

/// How the packets of one format look.
class PacketGrammar {
 public:
  virtual ~PacketGrammar() = default;
  [[nodiscard]] virtual std::uint16_t magic() const = 0;  ///< the first two bytes, little-endian
  [[nodiscard]] virtual std::size_t header_bytes() const = 0;
  [[nodiscard]] virtual std::uint64_t length(
      const ByteView& header) const = 0;  ///< stated by the header, all of the packet; 0 if it cannot be
  [[nodiscard]] virtual PacketContent content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const = 0;
};

struct Packet {
  std::uint64_t offset = 0;
  ByteView bytes;  ///< valid until the next call
};

/// Every step goes forward, and no byte is searched more than twice: a file of any content is read in a time proportional to its size.
class PacketReader {
 public:
  PacketReader(ByteSource& source, const PacketGrammar& grammar, LogProblems& problems, std::uint64_t first_offset,
               std::size_t max_packet_bytes)
      : source_(source), grammar_(grammar), problems_(problems), offset_(first_offset), max_packet_bytes_(max_packet_bytes) {}

  /// The next packet that lies in the file as a whole; none at the end.
  [[nodiscard]] std::optional<Packet> next();
  [[nodiscard]] std::uint64_t bytes_skipped() const { return bytes_skipped_; }  ///< in stretches that are no packets

 private:
  [[nodiscard]] bool starts_at(std::uint64_t offset) const;
  /// The length stated at `offset`; 0 without a start there, or if no packet is that short.
  [[nodiscard]] std::uint64_t length_at(std::uint64_t offset) const;
  [[nodiscard]] bool is_followed(std::uint64_t end) const { return end == source_.size() || starts_at(end); }
  /// The first packet that starts in [from, before): one that another follows, or that accounts for all its bytes.
  [[nodiscard]] std::optional<std::uint64_t> find(std::uint64_t from, std::uint64_t before) const;
  /// Goes on at the first packet from `from` on, and notes why at `place`.
  void resume(std::uint64_t place, std::uint64_t from, const char* what, const char* what_at_end);
  void leave(const PacketContent& content, std::uint64_t length);

  ByteSource& source_;
  const PacketGrammar& grammar_;
  LogProblems& problems_;
  std::uint64_t offset_;
  std::size_t max_packet_bytes_;
  std::uint64_t bytes_skipped_ = 0;
};

}  // namespace ssjs
