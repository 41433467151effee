/// Samples of a sonar log as linear echo strengths.
#pragma once

#include <cstddef>
#include <vector>

#include "ssjs/io/byte_source.hpp"

namespace ssjs {

enum class SampleKind {
  kUnsigned,   ///< little-endian integers of 1, 2, 4 or 8 bytes
  kMagnitude,  ///< signed integers of 2 bytes; their absolute value
  kComplex,    ///< pairs of signed integers of 2 bytes, real and imaginary part; their absolute value
  kIeeeFloat,
  kIbmFloat,  ///< base 16, sign and exponent first, little-endian
};

/// Weights beyond this are damage: 2^40 is more than any recorder's range.
constexpr int kMaxWeight = 40;

struct DecodedSamples {
  std::vector<float> strength;
  bool all_finite = true;  ///< what is not finite, or negative, is 0
};

/// `count` samples of `sample_bytes` from the start of `bytes` (which holds them), each times 2^-weight.
[[nodiscard]] DecodedSamples decode_samples(const ByteView& bytes, std::size_t count, std::size_t sample_bytes, SampleKind kind,
                                            int weight);

}  // namespace ssjs
