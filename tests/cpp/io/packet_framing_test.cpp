#include "ssjs/io/packet_framing.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ssjs {
namespace {

/// Packets 'P', 'K', a byte of length (all of it), a byte that counts the bytes that matter, then those.
class TwoLetterGrammar : public PacketGrammar {
 public:
  [[nodiscard]] std::uint16_t magic() const override { return 0x4B50; }
  [[nodiscard]] std::size_t header_bytes() const override { return 4; }
  [[nodiscard]] std::uint64_t length(const ByteView& header) const override { return header.u8(2); }
  [[nodiscard]] PacketContent content(ByteSource& source, std::uint64_t offset, std::uint64_t length) const override {
    const std::uint64_t used = 4U + source.view(offset, 4).u8(3);
    return {used <= length, used == length, used};
  }
};

std::string packet(const std::string& body) {
  return "PK" + std::string(1, static_cast<char>(4 + body.size())) + std::string(1, static_cast<char>(body.size())) + body;
}

struct Reading {
  std::vector<std::string> bodies;
  std::vector<LogProblem> problems;
  std::uint64_t skipped = 0;
};

Reading read(const std::string& log, std::size_t max_packet_bytes = 100) {
  MemoryBytes bytes(reinterpret_cast<const unsigned char*>(log.data()), log.size());
  const TwoLetterGrammar grammar;
  LogProblems problems;
  PacketReader reader(bytes, grammar, problems, 0, max_packet_bytes);
  Reading reading;
  while (const std::optional<Packet> found = reader.next())
    reading.bodies.emplace_back(reinterpret_cast<const char*>(found->bytes.data()) + 4, found->bytes.size() - 4);
  reading.problems = problems.all();
  reading.skipped = reader.bytes_skipped();
  return reading;
}

using Bodies = std::vector<std::string>;

TEST(PacketReader, ReadsPacketAfterPacket) {
  const Reading reading = read(packet("one") + packet("") + packet("three"));
  EXPECT_EQ(reading.bodies, (Bodies{"one", "", "three"}));
  EXPECT_TRUE(reading.problems.empty());
  EXPECT_TRUE(read("").bodies.empty());
}

TEST(PacketReader, FindsTheNextPacketBehindDamageAndSaysWhereItWas) {
  const Reading reading = read(packet("one") + "-noise-" + packet("two"));
  EXPECT_EQ(reading.bodies, (Bodies{"one", "two"}));
  ASSERT_EQ(reading.problems.size(), 1U);
  EXPECT_EQ(reading.problems[0].first_offset, 7U);
  EXPECT_EQ(reading.problems[0].loss, Loss::kData);
  EXPECT_EQ(reading.skipped, 7U);
}

TEST(PacketReader, ALengthOfZeroDoesNotStopIt) {
  std::string empty = packet("two");
  empty[2] = 0;
  EXPECT_EQ(read(packet("one") + empty + packet("three")).bodies, (Bodies{"one", "three"}));
}

TEST(PacketReader, ALengthBeyondTheLogCostsThatPacketAlone) {
  std::string broken = packet("two");
  broken[2] = 99;
  EXPECT_EQ(read(packet("one") + broken + packet("three")).bodies, (Bodies{"one", "three"}));
}

TEST(PacketReader, TheLastPacketMayBeCutAnywhere) {
  const std::string log = packet("one") + packet("two");
  for (std::size_t end = 8; end < log.size(); ++end) {
    const Reading reading = read(log.substr(0, end));
    EXPECT_EQ(reading.bodies, Bodies{"one"}) << end;
    EXPECT_EQ(reading.problems.size(), 1U) << end;
  }
}

TEST(PacketReader, TheMagicWithinAPacketIsItsContent) {
  EXPECT_EQ(read(packet("a PK b") + packet(packet("x"))).bodies, (Bodies{"a PK b", packet("x")}));
}

TEST(PacketReader, APacketLongerThanAllowedIsLeftOut) {
  const Reading reading = read(packet("one") + packet(std::string(60, 'x')) + packet("three"), 20);
  EXPECT_EQ(reading.bodies, (Bodies{"one", "three"}));
  ASSERT_EQ(reading.problems.size(), 1U);
}

TEST(PacketReader, FieldsThatContradictTheLengthAreNoPacket) {
  std::string broken = packet("two");
  broken[3] = 50;
  EXPECT_EQ(read(packet("one") + broken + packet("three")).bodies, (Bodies{"one", "three"}));
}

}  // namespace
}  // namespace ssjs
