#include "ssjs/base/checksum.hpp"

#include <gtest/gtest.h>

#include <string>

namespace ssjs {
namespace {

TEST(Crc64, HasTheCheckValueOfItsCatalogueEntry) { EXPECT_EQ(crc64("123456789"), 0x995DC9BBDF1939FAU); }

TEST(Crc64, GoesOnWhereItStopped) {
  const std::string text = "nineteen and some more bytes";
  for (std::size_t at = 0; at <= text.size(); ++at) EXPECT_EQ(crc64(text.substr(at), crc64(text.substr(0, at))), crc64(text)) << at;
}

TEST(Crc64, SeesEveryBit) {
  std::string text(100, 'x');
  const std::uint64_t whole = crc64(text);
  for (std::size_t bit = 0; bit < 8 * text.size(); ++bit) {
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_NE(crc64(text), whole) << bit;
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
  }
}

}  // namespace
}  // namespace ssjs
