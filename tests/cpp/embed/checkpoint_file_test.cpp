#include "ssjs/pipeline/checkpoint_file.hpp"

#include <gtest/gtest.h>

#include <string>

#include "ssjs/base/checksum.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const CheckpointOwner kOwner{"survey", {{"a", "1"}, {"b.c", "none"}}};

std::string complaint(const std::string& bytes, const CheckpointOwner& owner = kOwner) {
  try {
    static_cast<void>(open_checkpoint(owner, bytes, "f"));
  } catch (const FileError& problem) {
    return problem.what();
  }
  return "";
}

/// With the checksum that goes with the bytes.
std::string mended(std::string bytes) {
  std::uint64_t checksum = crc64(std::string_view(bytes).substr(0, bytes.size() - 9));
  for (std::size_t i = 1; i <= 8; ++i, checksum >>= 8U) bytes[bytes.size() - i] = static_cast<char>(checksum & 0xFFU);
  return bytes;
}

std::string replaced(std::string bytes, const std::string& old, const std::string& by) {
  bytes.replace(bytes.find(old), old.size(), by);
  return mended(bytes);
}

TEST(CheckpointSeal, HoldsTheStateByteForByte) {
  const std::string state("x\0y", 3);
  EXPECT_EQ(open_checkpoint(kOwner, seal_checkpoint(kOwner, state, "more"), "f"), state + "more");
  EXPECT_EQ(open_checkpoint(kOwner, seal_checkpoint(kOwner, "", ""), "f"), "");
}

/// A list of three (RFC 8949, 3.2.1, 3.4.5.1, 3.4.6): encoded CBOR of a map, a byte string, a number.
TEST(CheckpointSeal, IsCborAsTheFormatPageSays) {
  const std::string bytes = seal_checkpoint(kOwner, "12", "3");
  EXPECT_EQ(bytes.substr(0, 7), "\xd9\xd9\xf7\x83\xd8\x18\x5a");
  const std::size_t end = bytes.size() - 9;
  EXPECT_EQ(bytes.substr(end - 12, 12), std::string("\x5b\0\0\0\0\0\0\0\3", 9) + "123");
  EXPECT_EQ(bytes[end], '\x1b');
  EXPECT_EQ(mended(bytes), bytes);
  EXPECT_EQ(bytes[11], '\xa5');  // a map of five
}

TEST(CheckpointSeal, SaysWhatIsWrong) {
  const std::string bytes = seal_checkpoint(kOwner, "state", "");
  EXPECT_EQ(complaint(""), "f: is empty");
  EXPECT_EQ(complaint("{\"format\": \"something else\"}"), "f: is no checkpoint of this library");
  EXPECT_EQ(complaint(bytes.substr(0, 20)), "f: is cut off after 20 bytes");
  EXPECT_EQ(complaint(replaced(bytes, "ssjs-checkpoint", "ssjs-chickpoint")), "f: is no checkpoint of this library");
  EXPECT_EQ(complaint(replaced(bytes, std::string("gversion\x01"), "gversion\x02"))
                .find("f: is a checkpoint of format version 2, written by ssjs"),
            0U)
      << complaint(replaced(bytes, std::string("gversion\x01"), "gversion\x02"));
  EXPECT_EQ(complaint(bytes, {"planar survey", kOwner.configuration}), "f: is the state of another estimator: survey");
  EXPECT_EQ(complaint(bytes, {"survey", {{"a", "1"}, {"b.c", "0.5"}}}),
            "f: was made with another configuration: b.c = none, here it is 0.5");
  EXPECT_EQ(complaint(bytes, {"survey", {{"a", "1"}, {"b.c", "none"}, {"d", "2"}}}),
            "f: was made with another configuration: d = nothing, here it is 2");
  EXPECT_EQ(complaint(bytes, {"survey", {{"a", "1"}}}), "f: was made with a setting that is not known here: b.c");
  std::string huge = bytes;
  huge[7] = '\x7f';
  EXPECT_EQ(complaint(huge).find("f: is damaged: a header of"), 0U);
}

TEST(CheckpointSeal, AHeaderOfAMillionNestedListsIsRefused) {
  const std::string inner(1000000, '\x81');
  std::string bytes("\xd9\xd9\xf7\x83\xd8\x18\x5a\x00\x0f\x42\x40", 11);
  bytes += inner + std::string("\x5b\0\0\0\0\0\0\0\0\x1b\0\0\0\0\0\0\0\0", 18);
  EXPECT_EQ(complaint(mended(bytes)), "f: is damaged: its header cannot be read");
}

}  // namespace
}  // namespace ssjs
