#include "ssjs/base/checksum.hpp"

#include <array>
#include <cstddef>

namespace ssjs {
namespace {

constexpr std::uint64_t kPolynomial = 0xC96C5795D7870F42;  // ECMA-182, lowest bit first
constexpr std::size_t kAtOnce = 8;                         // bytes a step

using Tables = std::array<std::array<std::uint64_t, 256>, kAtOnce>;

/// Table k: what a byte does to the remainder with k more bytes behind it.
constexpr Tables make_tables() {
  Tables tables{};
  for (std::size_t byte = 0; byte < 256; ++byte) {
    std::uint64_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit) remainder = (remainder >> 1U) ^ ((remainder & 1U) != 0 ? kPolynomial : 0);
    tables[0][byte] = remainder;
  }
  for (std::size_t k = 1; k < kAtOnce; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint64_t shorter = tables[k - 1][byte];
      tables[k][byte] = (shorter >> 8U) ^ tables[0][shorter & 0xFFU];
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

std::uint64_t byte_at(std::string_view bytes, std::size_t i) { return static_cast<unsigned char>(bytes[i]); }

}  // namespace

std::uint64_t crc64(std::string_view bytes, std::uint64_t before) {
  std::uint64_t remainder = ~before;
  std::size_t i = 0;
  for (; i + kAtOnce <= bytes.size(); i += kAtOnce) {
    std::uint64_t next = 0;
    for (std::size_t k = 0; k < kAtOnce; ++k) {
      next ^= kTables[kAtOnce - 1 - k][(byte_at(bytes, i + k) ^ (remainder >> (8 * k))) & 0xFFU];
    }
    remainder = next;
  }
  for (; i < bytes.size(); ++i) remainder = (remainder >> 8U) ^ kTables[0][(byte_at(bytes, i) ^ remainder) & 0xFFU];
  return ~remainder;
}

}  // namespace ssjs
