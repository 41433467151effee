/// Fields of JSF messages, turned into SI. Offsets count from the end of the 16-byte message header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ssjs/io/packet_framing.hpp"
#include "ssjs/io/sample_decoding.hpp"
#include "ssjs/io/sonar_log.hpp"

namespace ssjs::jsf {

constexpr std::size_t kMessageHeaderBytes = 16;
constexpr std::size_t kTraceHeaderBytes = 240;

enum MessageType : unsigned { kTrace = 80, kPitchRoll = 2020, kPressure = 2060, kDopplerVelocity = 2080 };

/// How the samples of a trace are stored.
struct TraceSamples {
  std::size_t count = 0;
  std::size_t sample_bytes = 0;  ///< 0 for a format that is none
  SampleKind kind = SampleKind::kUnsigned;
};
[[nodiscard]] TraceSamples trace_samples(const ByteView& trace);

/// Heading, roll, pitch, speed, depth, altitude, sound speed and time of a trace header; the validity bits decide where they are used.
void read_trace_navigation(const ByteView& trace, std::uint64_t offset, SideScanPing& ping, SonarLogInfo& info);
/// The position of a trace header, layback not applied.
void read_trace_position(const ByteView& trace, std::uint64_t offset, SideScanPing& ping, SonarLogInfo& info);

/// Messages 2020, 2060 and 2080 as records: attitude; depth; velocity, altitude, depth and attitude.
void append_navigation(unsigned type, const ByteView& message, std::vector<SonarRecord>& records);

}  // namespace ssjs::jsf
