// Any bytes as a sonar log: no crash, no hang, no memory beyond what the bytes allow. Built with clang this is a libFuzzer target;
// without, mutation_driver.cpp feeds it. The first byte chooses the format, so that one corpus serves both.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "ssjs/io/byte_source.hpp"
#include "ssjs/io/jsf.hpp"
#include "ssjs/io/xtf.hpp"

namespace {

/// Each record must rest on bytes of its own: at least a packet header, and for samples a byte for every one.
void check_bounded(std::size_t records, std::size_t samples, std::size_t bytes) {
  if (records > bytes || samples > bytes) std::abort();
}

void read_all(ssjs::SonarLogReader& reader, std::size_t bytes) {
  std::size_t records = 0;
  std::size_t samples = 0;
  while (const std::optional<ssjs::SonarRecord> record = reader.next()) {
    ++records;
    if (const auto* ping = std::get_if<ssjs::SideScanPing>(&*record)) {
      for (const ssjs::SideScanChannel& channel : ping->channels) samples += channel.samples.size();
    }
    check_bounded(records, samples, bytes);
  }
  if (reader.next()) std::abort();  // the end stays the end
  if (reader.info().bytes_skipped > bytes || reader.info().problems.all().size() > 64) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  auto source = std::make_unique<ssjs::MemoryBytes>(data + 1, size - 1);
  if ((data[0] & 1U) == 0) {
    ssjs::XtfReader reader(std::move(source));
    read_all(reader, size);
  } else {
    ssjs::JsfReader reader(std::move(source));
    read_all(reader, size);
  }
  return 0;
}
