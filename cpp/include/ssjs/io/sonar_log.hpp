/// A side-scan log read record by record, whatever its format. Conventions and decisions: docs/sonar_logs.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "ssjs/io/byte_source.hpp"
#include "ssjs/io/log_problems.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"

namespace ssjs {

// Records beside the pings. Times in s, UTC since 1970; what a record does not give is NaN.

/// A position from a record of its own; WGS84 degrees, or projected metres where the log has those.
struct PositionRecord {
  double time_s = SideScanPing::kUnknown;
  double latitude_deg = SideScanPing::kUnknown, longitude_deg = SideScanPing::kUnknown;
  double east_m = SideScanPing::kUnknown, north_m = SideScanPing::kUnknown;
};

/// Bow up, starboard down and clockwise from true north are positive.
struct AttitudeRecord {
  double time_s = SideScanPing::kUnknown;
  double roll_rad = SideScanPing::kUnknown, pitch_rad = SideScanPing::kUnknown, heading_rad = SideScanPing::kUnknown;
};

/// Velocity over the bottom, body axes.
struct VelocityRecord {
  double time_s = SideScanPing::kUnknown;
  double forward_m_s = SideScanPing::kUnknown, starboard_m_s = SideScanPing::kUnknown, down_m_s = SideScanPing::kUnknown;
  bool bottom_lock = false;
};

struct DepthRecord {
  double time_s = SideScanPing::kUnknown;
  double depth_m = SideScanPing::kUnknown;
};

struct AltitudeRecord {
  double time_s = SideScanPing::kUnknown;
  double altitude_m = SideScanPing::kUnknown;
};

using SonarRecord = std::variant<SideScanPing, PositionRecord, AttitudeRecord, VelocityRecord, DepthRecord, AltitudeRecord>;

/// Whether recorded positions are moved back to the towed sonar by its layback.
enum class LaybackMode {
  kAsFormat,  ///< XTF: a layback that is not zero says it has still to be applied; JSF: positions are those of the sonar
  kApply,
  kIgnore,
};

/// Nothing in a log makes a reader allocate more than these allow.
struct SonarLogConfig {
  LaybackMode layback = LaybackMode::kAsFormat;
  std::size_t max_packet_bytes = std::size_t{16} * 1024 * 1024;
  std::size_t max_channel_samples = std::size_t{1} << 20U;
};

/// How often each choice was made.
class Tally {
 public:
  void count(std::string_view choice);
  [[nodiscard]] const std::map<std::string, std::uint64_t, std::less<>>& counts() const { return counts_; }
  /// The most frequent choice, the first of the alphabet among equals; empty without any.
  [[nodiscard]] std::string leading() const;

 private:
  std::map<std::string, std::uint64_t, std::less<>> counts_;
};

/// What a log holds and what its reader decided, complete when the last record has been read.
struct SonarLogInfo {
  std::string format;           ///< "xtf" or "jsf"
  std::string recorder, sonar;  ///< as the log names them
  std::uint64_t pings = 0;
  std::map<unsigned, std::uint64_t> packet_types;                                         ///< number of packets of each type
  Tally time_source, position_source, layback_mode, altitude_source, sound_speed_source;  ///< one choice a ping
  std::uint64_t repeated_positions = 0;  ///< pings that carry the position of the one before
  std::uint64_t bytes_skipped = 0;       ///< in stretches that are no packets
  LogProblems problems;
};

class SonarLogReader {
 public:
  virtual ~SonarLogReader() = default;
  /// The next record of the log, in its order; none at the end. Damage is noted and passed over.
  [[nodiscard]] virtual std::optional<SonarRecord> next() = 0;
  [[nodiscard]] virtual const SonarLogInfo& info() const = 0;
};

/// Reads `path` by what it holds, not by its name. Throws FileError if it is neither XTF nor JSF or cannot be read.
[[nodiscard]] std::unique_ptr<SonarLogReader> open_sonar_log(const std::string& path, const SonarLogConfig& config = {});

}  // namespace ssjs
