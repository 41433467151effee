#include "ssjs/io/sample_decoding.hpp"

#include <cmath>
#include <cstdint>

namespace ssjs {
namespace {

template <class Decode>
DecodedSamples decode_each(const ByteView& bytes, std::size_t count, std::size_t sample_bytes, int weight, const Decode& decode) {
  DecodedSamples samples;
  samples.strength.reserve(count);
  const double scale = std::ldexp(1.0, -weight);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<float>(decode(bytes, i * sample_bytes) * scale);
    const bool usable = std::isfinite(value) && value >= 0.0F;
    samples.all_finite = samples.all_finite && usable;
    samples.strength.push_back(usable ? value : 0.0F);
  }
  return samples;
}

/// Sign, 7 bits of exponent to the base 16, 24 bits of fraction below the point.
double ibm_float(std::uint32_t bits) {
  const int exponent = static_cast<int>((bits >> 24U) & 0x7FU) - 64;
  const double magnitude = std::ldexp(static_cast<double>(bits & 0xFFFFFFU), 4 * exponent - 24);
  return (bits >> 31U) != 0 ? -magnitude : magnitude;
}

}  // namespace

DecodedSamples decode_samples(const ByteView& bytes, std::size_t count, std::size_t sample_bytes, SampleKind kind, int weight) {
  const auto each = [&](const auto& decode) { return decode_each(bytes, count, sample_bytes, weight, decode); };
  switch (kind) {
    case SampleKind::kMagnitude:
      return each([](const ByteView& b, std::size_t at) { return std::abs(static_cast<double>(b.i16(at))); });
    case SampleKind::kComplex:
      return each(
          [](const ByteView& b, std::size_t at) { return std::hypot(static_cast<double>(b.i16(at)), static_cast<double>(b.i16(at + 2))); });
    case SampleKind::kIeeeFloat:
      return each([](const ByteView& b, std::size_t at) { return static_cast<double>(b.f32(at)); });
    case SampleKind::kIbmFloat:
      return each([](const ByteView& b, std::size_t at) { return ibm_float(b.u32(at)); });
    case SampleKind::kUnsigned:
      break;
  }
  if (sample_bytes == 1) return each([](const ByteView& b, std::size_t at) { return static_cast<double>(b.u8(at)); });
  if (sample_bytes == 2) return each([](const ByteView& b, std::size_t at) { return static_cast<double>(b.u16(at)); });
  if (sample_bytes == 4) return each([](const ByteView& b, std::size_t at) { return static_cast<double>(b.u32(at)); });
  return each([](const ByteView& b, std::size_t at) { return b.u32(at) + 4294967296.0 * b.u32(at + 4); });
}

}  // namespace ssjs
