/// Bytes of a fuzzer taken apart into values: what comes after the end is zero, so that every input means something.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace ssjs::fuzz {

class ByteStream {
 public:
  ByteStream(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  [[nodiscard]] bool empty() const { return at_ == end_; }

  std::uint8_t byte() { return at_ == end_ ? std::uint8_t{0} : *at_++; }

  /// Below `limit`, which is at most 256.
  std::size_t below(std::size_t limit) { return byte() % limit; }

  /// 16 bits over [-scale, scale]: values that sensors give.
  double plausible(double scale) {
    const int low = byte();
    const int whole = low + 256 * byte();
    return scale * (static_cast<double>(whole) / 32767.5 - 1.0);
  }

  /// Eight bytes as they are: NaN, infinity and the ends of the range are among them.
  double any() {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 8; ++i) bits |= static_cast<std::uint64_t>(byte()) << (8U * i);
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

  /// Up to the next `mark` or the end; the mark is taken too.
  std::string until(std::uint8_t mark) {
    const std::uint8_t* const stop = std::find(at_, end_, mark);
    std::string text(at_, stop);
    at_ = stop == end_ ? end_ : stop + 1;
    return text;
  }

 private:
  const std::uint8_t* at_;
  const std::uint8_t* end_;
};

}  // namespace ssjs::fuzz
