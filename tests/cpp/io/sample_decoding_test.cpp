#include "ssjs/io/sample_decoding.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ssjs {
namespace {

using Bytes = std::vector<unsigned char>;

std::vector<float> decode(const Bytes& bytes, std::size_t sample_bytes, SampleKind kind, int weight = 0) {
  return decode_samples({bytes.data(), bytes.size()}, bytes.size() / sample_bytes, sample_bytes, kind, weight).strength;
}

TEST(DecodeSamples, LittleEndianIntegers) {
  EXPECT_EQ(decode({1, 255}, 1, SampleKind::kUnsigned), (std::vector<float>{1.0F, 255.0F}));
  EXPECT_EQ(decode({0x34, 0x12, 0xFF, 0xFF}, 2, SampleKind::kUnsigned), (std::vector<float>{4660.0F, 65535.0F}));
  EXPECT_EQ(decode({0, 0, 1, 0}, 4, SampleKind::kUnsigned), (std::vector<float>{65536.0F}));
  EXPECT_EQ(decode({0, 0, 0, 0, 1, 0, 0, 0}, 8, SampleKind::kUnsigned), (std::vector<float>{4294967296.0F}));
}

TEST(DecodeSamples, SignedAndComplexGiveTheirMagnitude) {
  EXPECT_EQ(decode({0xFE, 0xFF, 0x00, 0x80}, 2, SampleKind::kMagnitude), (std::vector<float>{2.0F, 32768.0F}));
  EXPECT_EQ(decode({3, 0, 0xFC, 0xFF}, 4, SampleKind::kComplex), (std::vector<float>{5.0F}));
}

TEST(DecodeSamples, FloatsOfBothKinds) {
  EXPECT_EQ(decode({0, 0, 0xC0, 0x3F}, 4, SampleKind::kIeeeFloat), (std::vector<float>{1.5F}));
  // 0x42640000: exponent 0x42 - 64 = 2, fraction 0x640000 / 2^24 = 100 / 256; times 16^2
  EXPECT_EQ(decode({0x00, 0x00, 0x64, 0x42}, 4, SampleKind::kIbmFloat), (std::vector<float>{100.0F}));
}

TEST(DecodeSamples, TheWeightIsAPowerOfTwo) {
  EXPECT_EQ(decode({48}, 1, SampleKind::kUnsigned, 4), (std::vector<float>{3.0F}));
  EXPECT_EQ(decode({3}, 1, SampleKind::kUnsigned, -4), (std::vector<float>{48.0F}));
}

TEST(DecodeSamples, WhatIsNoEchoStrengthIsZeroAndSaid) {
  const Bytes not_a_number = {0, 0, 0xC0, 0x7F, 0, 0, 0x80, 0xBF};  // NaN, -1
  const DecodedSamples samples = decode_samples({not_a_number.data(), not_a_number.size()}, 2, 4, SampleKind::kIeeeFloat, 0);
  EXPECT_EQ(samples.strength, (std::vector<float>{0.0F, 0.0F}));
  EXPECT_FALSE(samples.all_finite);
}

TEST(ByteView, NothingIsReadBeyondItsEnd) {
  const Bytes bytes = {1, 2, 3};
  const ByteView view(bytes.data(), bytes.size());
  EXPECT_EQ(view.u16(1), 0x0302);
  EXPECT_THROW((void)view.u16(2), Error);
  EXPECT_THROW((void)view.u8(3), Error);
  EXPECT_THROW((void)view.part(1, static_cast<std::size_t>(-1)), Error);
}

}  // namespace
}  // namespace ssjs
