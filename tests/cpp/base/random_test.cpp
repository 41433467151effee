#include "ssjs/base/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// The published reference code (prng.di.unimi.it), transcribed as it stands; the tests hold it to published outputs first.
struct Splitmix64 {
  std::uint64_t x;
  std::uint64_t next() {
    std::uint64_t z = (x += 0x9e3779b97f4a7c15U);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }
};

struct Xoshiro256StarStar {
  std::array<std::uint64_t, 4> s;
  static std::uint64_t rotl(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }
  std::uint64_t next() {
    const std::uint64_t result = rotl(s[1] * 5, 7) * 9;
    const std::uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = rotl(s[3], 45);
    return result;
  }
};

TEST(Rng, ReferenceCodeGivesThePublishedNumbers) {
  // splitmix64 of seed 1234567: Rosetta Code, "Pseudo-random numbers/Splitmix64".
  Splitmix64 splitmix{1234567};
  for (const std::uint64_t expected :
       {6457827717110365317U, 3203168211198807973U, 9817491932198370423U, 4593380528125082431U, 16408922859458223821U}) {
    EXPECT_EQ(splitmix.next(), expected);
  }
  // xoshiro256** from the state 1, 2, 3, 4: the test vector of the rand_xoshiro crate, made with the authors' C code.
  Xoshiro256StarStar xoshiro{{1, 2, 3, 4}};
  for (const std::uint64_t expected :
       {std::uint64_t{11520}, std::uint64_t{0}, std::uint64_t{1509978240}, std::uint64_t{1215971899390074240},
        std::uint64_t{1216172134540287360}, std::uint64_t{607988272756665600}}) {
    EXPECT_EQ(xoshiro.next(), expected);
  }
}

TEST(Rng, IsXoshiroSeededThroughSplitmix) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1234567}, ~std::uint64_t{0}}) {
    Splitmix64 splitmix{seed};
    Xoshiro256StarStar reference{};
    for (std::uint64_t& word : reference.s) word = splitmix.next();
    Rng rng(seed);
    for (int i = 0; i < 100; ++i) ASSERT_EQ(rng.next(), reference.next()) << "seed " << seed << ", draw " << i;
  }
}

TEST(Rng, SameSeedSameNumbersOtherSeedOthers) {
  Rng a(7);
  Rng b(7);
  Rng c(8);
  int equal_to_other_seed = 0;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t value = a.next();
    EXPECT_EQ(value, b.next());
    if (value == c.next()) ++equal_to_other_seed;
  }
  EXPECT_EQ(equal_to_other_seed, 0);
}

TEST(Rng, StreamDependsOnSeedAndNameAlone) {
  Rng fresh(7);
  Rng used(7);
  (void)used.next();
  (void)used.normal();
  Rng a = fresh.stream("range");
  Rng b = used.stream("range");
  for (int i = 0; i < 10; ++i) EXPECT_EQ(a.next(), b.next());
}

TEST(Rng, TakingAStreamDoesNotAdvanceTheSource) {
  Rng with_stream(7);
  Rng without(7);
  (void)with_stream.stream("bearing");
  EXPECT_EQ(with_stream.next(), without.next());
}

TEST(Rng, StreamsOfOtherNamesSeedsAndDepthsDiffer) {
  const Rng root(7);
  std::vector<Rng> streams = {root,
                              root.stream(""),
                              root.stream("a"),
                              root.stream("b"),
                              root.stream("ab"),
                              root.stream("ba"),
                              root.stream("a").stream("a"),
                              root.stream("a").stream("b"),
                              Rng(8).stream("a"),
                              Rng(8).stream("b")};
  std::vector<std::uint64_t> first;
  for (Rng& stream : streams) first.push_back(stream.next());
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(first[i], first[j]) << i << " and " << j;
  }
}

/// |correlation| of n independent pairs exceeds 4.9 / sqrt(n) with a probability of 1e-6.
double correlation_of_normals(Rng a, Rng b, int n) {
  double aa = 0.0;
  double bb = 0.0;
  double ab = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = a.normal();
    const double y = b.normal();
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  return ab / std::sqrt(aa * bb);
}

TEST(Rng, StreamsAreUncorrelated) {
  constexpr int kDraws = 20000;
  const double bound = 4.9 / std::sqrt(kDraws);
  const Rng root(42);
  EXPECT_LT(std::abs(correlation_of_normals(root, root.stream("speed"), kDraws)), bound);
  EXPECT_LT(std::abs(correlation_of_normals(root.stream("speed"), root.stream("steering"), kDraws)), bound);
  EXPECT_LT(std::abs(correlation_of_normals(Rng(1).stream("speed"), Rng(2).stream("speed"), kDraws)), bound);
}

TEST(Rng, UniformIsTheTopFiftyThreeBits) {
  Rng rng(3);
  Rng same(3);
  for (int i = 0; i < 1000; ++i) {
    const double value = rng.uniform();
    EXPECT_EQ(value, std::ldexp(static_cast<double>(same.next() / 2048), -53));
    EXPECT_GE(value, 0.0);
    EXPECT_LT(value, 1.0);
  }
}

TEST(Rng, UniformIntervalIsHalfOpen) {
  Rng rng(3);
  const double high = std::nextafter(1.0, 2.0);  // only one number lies in [1, high): half of the roundings land on high
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rng.uniform(1.0, high), 1.0);
  for (int i = 0; i < 1000; ++i) {
    const double value = rng.uniform(-3.0, 5.0);
    EXPECT_GE(value, -3.0);
    EXPECT_LT(value, 5.0);
  }
  EXPECT_EQ(rng.uniform(2.0, 2.0), 2.0);  // a jitter of nothing
}

TEST(Rng, UniformRefusesATurnedOrEndlessInterval) {
  Rng rng(3);
  EXPECT_THROW(rng.uniform(1.0, 0.0), InvalidArgument);
  EXPECT_THROW(rng.uniform(0.0, INFINITY), InvalidArgument);
  EXPECT_THROW(rng.uniform(std::nan(""), 1.0), InvalidArgument);
}

TEST(Rng, BelowHitsEveryValueEvenly) {
  constexpr std::uint64_t kBound = 6;
  constexpr int kDraws = 60000;
  std::array<int, kBound> counts{};
  Rng rng(11);
  for (int i = 0; i < kDraws; ++i) {
    const std::uint64_t value = rng.below(kBound);
    ASSERT_LT(value, kBound);
    ++counts[value];
  }
  const double expected = static_cast<double>(kDraws) / kBound;
  double statistic = 0.0;
  for (const int count : counts) statistic += (count - expected) * (count - expected) / expected;
  EXPECT_LT(statistic, chi_squared_quantile(1.0 - 1e-6, kBound - 1.0));  // Pearson's test
}

TEST(Rng, BelowRejectsTheSurplusOfTheRange) {
  // bound = 3 * 2^62: the first 2^64 mod bound = 2^62 values (a quarter) are drawn again, the others taken modulo bound.
  constexpr std::uint64_t kBound = std::uint64_t{3} << 62;
  Rng rng(5);
  Rng same(5);
  for (int i = 0; i < 1000; ++i) {
    std::uint64_t value = same.next();
    while (value < (std::uint64_t{1} << 62)) value = same.next();
    ASSERT_EQ(rng.below(kBound), value % kBound);
  }
}

TEST(Rng, BelowOneIsZeroAndBelowNothingIsRefused) {
  Rng rng(5);
  EXPECT_EQ(rng.below(1), 0U);
  EXPECT_THROW(rng.below(0), InvalidArgument);
}

TEST(Rng, NormalHasTheMomentsAndTailsOfTheNormal) {
  constexpr int kDraws = 200000;
  const double n = kDraws;
  Rng rng(17);
  double sum = 0.0;
  double squares = 0.0;
  double fourths = 0.0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = rng.normal();
    sum += value;
    squares += value * value;
    fourths += value * value * value * value;
    if (std::abs(value) > 2.0) ++beyond_two;
  }
  // Five standard deviations of each estimate: var(x) = 1, var(x^2) = 3 - 1 = 2, var(x^4) = 105 - 9 = 96.
  EXPECT_NEAR(sum / n, 0.0, 5.0 * std::sqrt(1.0 / n));
  EXPECT_NEAR(squares / n, 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourths / n, 3.0, 5.0 * std::sqrt(96.0 / n));
  const double p = std::erfc(2.0 / std::sqrt(2.0));
  EXPECT_NEAR(beyond_two / n, p, 5.0 * std::sqrt(p * (1.0 - p) / n));
}

TEST(Rng, NormalScalesByTheStandardDeviation) {
  Rng rng(17);
  Rng same(17);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(rng.normal(0.25), 0.25 * same.normal());
  EXPECT_EQ(rng.normal(0.0), 0.0);
}

}  // namespace
}  // namespace ssjs
