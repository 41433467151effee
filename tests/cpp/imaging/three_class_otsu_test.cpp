#include "ssjs/imaging/three_class_otsu.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// The variance between the classes as it is defined: sum over them of weight x (mean - mean of all)^2; negative if one is empty.
double variance_between(const Histogram& histogram, int lower, int upper) {
  std::array<double, 3> pixels{};
  std::array<double, 3> sum{};
  for (int level = 0; level < histogram.levels(); ++level) {
    const std::size_t c = level <= lower ? 0 : level <= upper ? 1 : 2;
    pixels.at(c) += static_cast<double>(histogram[level]);
    sum.at(c) += static_cast<double>(histogram[level]) * level;
  }
  const double all = pixels[0] + pixels[1] + pixels[2];
  const double mean = (sum[0] + sum[1] + sum[2]) / all;
  double variance = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (pixels.at(c) == 0) return -1;
    variance += pixels.at(c) / all * std::pow(sum.at(c) / pixels.at(c) - mean, 2);
  }
  return variance;
}

TEST(ThreeClassOtsuTest, R11_ThreeLevelsAreTheirOwnClasses) {
  Histogram histogram{std::vector<std::int64_t>(256, 0)};
  histogram.counts[10] = 5;
  histogram.counts[90] = 1000;
  histogram.counts[240] = 3;
  const auto classes = three_class_otsu(histogram);
  ASSERT_TRUE(classes);
  EXPECT_EQ(classes->lower, 10);  // the lowest of the equal splits 10..89
  EXPECT_EQ(classes->upper, 90);
}

TEST(ThreeClassOtsuTest, R11_NoSplitHasMoreVarianceBetween) {
  Rng rng(17);
  for (int trial = 0; trial < 20; ++trial) {
    Histogram histogram{std::vector<std::int64_t>(40, 0)};
    for (std::int64_t& count : histogram.counts) count = rng.uniform(0, 1) < 0.3 ? 0 : static_cast<std::int64_t>(rng.uniform(0, 500));
    const auto classes = three_class_otsu(histogram);
    ASSERT_TRUE(classes);
    const double best = variance_between(histogram, classes->lower, classes->upper);
    for (int lower = 0; lower < 40; ++lower) {
      for (int upper = lower + 1; upper < 40; ++upper) EXPECT_LE(variance_between(histogram, lower, upper), best * (1 + 1e-12));
    }
  }
}

TEST(ThreeClassOtsuTest, FewerThanThreeLevelsHaveNoThreeClasses) {
  Histogram histogram{std::vector<std::int64_t>(256, 0)};
  EXPECT_FALSE(three_class_otsu(histogram));
  histogram.counts[0] = 7;
  histogram.counts[255] = 7;
  EXPECT_FALSE(three_class_otsu(histogram));
  histogram.counts[3] = 1;
  EXPECT_TRUE(three_class_otsu(histogram));
  EXPECT_THROW(static_cast<void>(three_class_otsu({std::vector<std::int64_t>(65536, 1)})), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
