/// Logs in the eXtended Triton Format. Side-scan pings (type 0), navigation (42, 107), attitude (3) and gyro (23, 84) are read, every
/// other type is counted. Conventions: docs/sonar_logs.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "ssjs/io/log_clock.hpp"
#include "ssjs/io/packet_framing.hpp"
#include "ssjs/io/sonar_log.hpp"
#include "ssjs/io/xtf_layout.hpp"

namespace ssjs {

[[nodiscard]] bool looks_like_xtf(ByteSource& source);

class XtfReader : public SonarLogReader {
 public:
  explicit XtfReader(std::unique_ptr<ByteSource> source, const SonarLogConfig& config = {});
  [[nodiscard]] std::optional<SonarRecord> next() override;
  [[nodiscard]] const SonarLogInfo& info() const override { return info_; }

 private:
  [[nodiscard]] std::optional<SonarRecord> decode(const Packet& packet);
  [[nodiscard]] std::optional<SonarRecord> decode_ping(const Packet& packet);
  void read_time(const Packet& packet, SideScanPing& ping);
  void read_position(const Packet& packet, SideScanPing& ping);
  void read_channels(const Packet& packet, SideScanPing& ping);

  std::unique_ptr<ByteSource> source_;
  SonarLogConfig config_;
  SonarLogInfo info_;
  XtfLayout layout_;
  PacketReader packets_;
  std::optional<SonarRecord> waiting_;  ///< the second record of a packet that holds two
  MillisecondCounter ping_counter_{0.01};
  MillisecondCounter fix_counter_{0.01};
  double last_latitude_deg_ = SideScanPing::kUnknown, last_longitude_deg_ = SideScanPing::kUnknown;
  double last_east_m_ = SideScanPing::kUnknown, last_north_m_ = SideScanPing::kUnknown;
};

}  // namespace ssjs
