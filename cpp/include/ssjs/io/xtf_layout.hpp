/// Where things lie in an XTF log: its file header, and the channels within a ping packet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/io/packet_framing.hpp"

namespace ssjs {

namespace xtf {

constexpr std::size_t kFileHeaderBytes = 1024;
constexpr std::size_t kPacketHeaderBytes = 14;
constexpr std::size_t kPingHeaderBytes = 256;
constexpr std::size_t kChannelHeaderBytes = 64;
constexpr std::size_t kMaxChannels = 64;  ///< in one ping

enum PacketType : unsigned { kSonar = 0, kAttitude = 3, kGyro = 23, kNavigation = 42, kSourceTimeGyro = 84, kRawNavigation = 107 };
enum class SampleFormat : std::uint8_t { kUnsigned, kIbmFloat, kIeeeFloat };

/// What the file header says about one channel (CHANINFO).
struct ChannelInfo {
  unsigned type = 0;  ///< 0 sub-bottom, 1 port, 2 starboard, 3 bathymetry
  std::size_t sample_bytes = 0;
  SampleFormat format = SampleFormat::kUnsigned;
  std::uint32_t samples = 0;  ///< older logs say here, and not in each ping, how many there are
  double frequency_hz = 0.0;
};

/// One channel within a ping packet; positions from the start of the packet.
struct ChannelPlace {
  std::size_t header = 0, samples = 0, sample_count = 0, sample_bytes = 0;
  unsigned number = 0;
  std::optional<ChannelInfo> info;
};

}  // namespace xtf

/// The grammar of XTF packets. It needs the file header: that alone tells how many bytes a sample has.
class XtfLayout : public PacketGrammar {
 public:
  /// A header that is too short or damaged leaves what it does not tell unknown.
  explicit XtfLayout(ByteSource& source);

  [[nodiscard]] std::uint16_t magic() const override { return 0xFACE; }
  [[nodiscard]] std::size_t header_bytes() const override { return xtf::kPacketHeaderBytes; }
  [[nodiscard]] std::uint64_t length(const ByteView& header) const override { return header.u32(10); }
  [[nodiscard]] PacketContent content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const override;

  /// The channels of a ping packet of `length` bytes, those only that lie in it as a whole.
  [[nodiscard]] std::vector<xtf::ChannelPlace> channels(ByteSource& source, std::uint64_t offset, std::uint64_t length) const;

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< of the file header
  [[nodiscard]] bool knows_side_scan() const { return knows_side_scan_; }
  [[nodiscard]] unsigned navigation_units() const { return navigation_units_; }
  [[nodiscard]] const std::string& recorder() const { return recorder_; }
  [[nodiscard]] const std::string& sonar() const { return sonar_; }

 private:
  [[nodiscard]] std::optional<xtf::ChannelInfo> info_of(unsigned number, std::size_t position) const;
  [[nodiscard]] std::vector<xtf::ChannelPlace> places(ByteSource& source, std::uint64_t offset, std::uint64_t length,
                                                      std::size_t unknown_sample_bytes) const;

  std::vector<xtf::ChannelInfo> channels_;
  std::uint64_t bytes_ = xtf::kFileHeaderBytes;
  bool knows_side_scan_ = false;
  unsigned navigation_units_ = 3;
  std::string recorder_, sonar_;
};

}  // namespace ssjs
