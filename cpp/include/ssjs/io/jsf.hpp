/// Logs in EdgeTech's JSF. Side-scan traces (message 80 of subsystems 20 to 22), pitch and roll (2020), pressure (2060) and Doppler
/// velocity (2080) are read, every other message is counted. Conventions: docs/sonar_logs.md.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "ssjs/io/packet_framing.hpp"
#include "ssjs/io/sonar_log.hpp"

namespace ssjs {

[[nodiscard]] bool looks_like_jsf(ByteSource& source);

/// The grammar of JSF messages: 16 bytes of header, then as many as it says.
class JsfGrammar : public PacketGrammar {
 public:
  [[nodiscard]] std::uint16_t magic() const override { return 0x1601; }
  [[nodiscard]] std::size_t header_bytes() const override { return 16; }
  [[nodiscard]] std::uint64_t length(const ByteView& header) const override;
  [[nodiscard]] PacketContent content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const override;
};

/// The two sides of a ping come in messages of their own and are put together by subsystem and ping number.
class JsfReader : public SonarLogReader {
 public:
  explicit JsfReader(std::unique_ptr<ByteSource> source, const SonarLogConfig& config = {});
  [[nodiscard]] std::optional<SonarRecord> next() override;
  [[nodiscard]] const SonarLogInfo& info() const override { return info_; }

 private:
  void decode(const Packet& packet);
  void add_trace(const Packet& packet);
  void finish(unsigned subsystem);
  [[nodiscard]] SideScanPing ping_of(const Packet& packet);
  [[nodiscard]] std::optional<SideScanChannel> channel_of(const Packet& packet);

  std::unique_ptr<ByteSource> source_;
  SonarLogConfig config_;
  JsfGrammar grammar_;
  SonarLogInfo info_;
  PacketReader packets_;
  std::map<unsigned, SideScanPing> unfinished_;  ///< by subsystem
  std::vector<SonarRecord> ready_;               ///< of the last message, the first `taken_` of them handed out
  std::size_t taken_ = 0;
  double last_x_ = SideScanPing::kUnknown, last_y_ = SideScanPing::kUnknown;
};

}  // namespace ssjs
