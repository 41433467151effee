#include "ssjs/cascade/stump_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cascade/search_problem.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

std::vector<double> random_weights(std::size_t count, Rng& rng) {
  std::vector<double> weights(count);
  double sum = 0;
  for (double& weight : weights) sum += weight = std::exp(2 * rng.normal());
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Weighted squared error (Gentle) or error (Discrete) of the best stump of one feature, by trying every gap between its values.
double least_loss(const std::vector<float>& values, std::size_t positives, const std::vector<double>& weights, BoostType type) {
  std::vector<std::size_t> order(values.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  double all[2] = {0, 0};
  for (std::size_t i = 0; i < weights.size(); ++i) all[i < positives ? 1 : 0] += weights[i];
  double left[2] = {0, 0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 1 < order.size(); ++k) {
    left[order[k] < positives ? 1 : 0] += weights[order[k]];
    if (!(values[order[k]] < values[order[k + 1]])) continue;
    const double right[2] = {all[0] - left[0], all[1] - left[1]};
    double loss = 0;
    if (type == BoostType::kDiscrete) {
      loss = std::min(left[1] + right[0], left[0] + right[1]);
    } else {
      for (const double* side : {static_cast<const double*>(left), right}) {
        const double mean = (side[1] - side[0]) / (side[1] + side[0]);
        loss += side[1] * (1 - mean) * (1 - mean) + side[0] * (1 + mean) * (1 + mean);
      }
    }
    least = std::min(least, loss);
  }
  return least;
}

double loss_of(const Stump& stump, const FeatureTable& table, const std::vector<double>& weights, BoostType type) {
  std::vector<float> values(table.samples());
  table.values(stump.feature, values.data());
  double loss = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double label = i < table.positives() ? 1 : -1;
    const double answer = values[i] < stump.threshold ? stump.left : stump.right;
    loss += weights[i] * (type == BoostType::kGentle ? (label - answer) * (label - answer) : (label * answer > 0 ? 0.0 : 1.0));
  }
  return loss;
}

class StumpSearchTest : public testing::TestWithParam<BoostType> {};

TEST_P(StumpSearchTest, C9_EqualsTryingEveryThresholdOfEveryFeature) {
  const BoostType type = GetParam();
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Problem problem = make_problem({9, 8}, seed % 2 == 0 ? FeatureSet::kAll : FeatureSet::kSideScan, 60, 90, seed);
    const FeatureTable table(problem.features, problem.positives, problem.negatives, 1U << 30U, 2);
    ASSERT_EQ(table.samples(), 150U);
    Rng rng(seed);
    const std::vector<double> weights = random_weights(table.samples(), rng);
    double least = std::numeric_limits<double>::infinity();
    std::vector<float> values(table.samples());
    for (std::size_t f = 0; f < table.features(); ++f) {
      table.values(f, values.data());
      least = std::min(least, least_loss(values, table.positives(), weights, type));
    }
    const auto stump = best_stump(table, weights, type, 2);
    ASSERT_TRUE(stump);
    EXPECT_NEAR(loss_of(*stump, table, weights, type), least, 150 * std::ldexp(1.0, -30)) << "seed " << seed;  // each weight rounded once
  }
}

TEST_P(StumpSearchTest, IsTheSameOnAnyNumberOfThreadsAndWithAnyMemory) {
  const Problem problem = make_problem({12, 12}, FeatureSet::kAll, 100, 150, 77);
  const FeatureTable kept(problem.features, problem.positives, problem.negatives, 1U << 30U, 1);
  const FeatureTable formed_anew(problem.features, problem.positives, problem.negatives, 250 * 1000, 2);
  Rng rng(5);
  const std::vector<double> weights = random_weights(kept.samples(), rng);
  const auto expected = best_stump(kept, weights, GetParam(), 1);
  ASSERT_TRUE(expected);
  for (const FeatureTable* table : {&kept, &formed_anew})
    for (const int threads : {1, 2, 5}) {
      const auto stump = best_stump(*table, weights, GetParam(), threads);
      ASSERT_TRUE(stump);
      EXPECT_EQ(stump->feature, expected->feature);
      EXPECT_EQ(stump->threshold, expected->threshold);
      EXPECT_EQ(stump->left, expected->left);
      EXPECT_EQ(stump->right, expected->right);
    }
}

INSTANTIATE_TEST_SUITE_P(BothKinds, StumpSearchTest, testing::Values(BoostType::kGentle, BoostType::kDiscrete),
                         [](const auto& test) { return to_string(test.param); });

TEST(StumpSearchLimitsTest, AWindowThatDiffersFromNoneCannotBeSplit) {
  Rng rng(1);
  WindowSet same({8, 8});
  const cv::Mat picture = speckle({8, 8}, rng);
  for (int i = 0; i < 5; ++i) same.add(picture);
  const auto features = enumerate_features(FeatureSet::kBasic, {8, 8});
  const FeatureTable table(features, same, same, 1U << 20U, 1);
  EXPECT_FALSE(best_stump(table, std::vector<double>(10, 0.1), BoostType::kGentle, 1));
}

TEST(StumpSearchLimitsTest, FlatWindowsAreLeftOut) {
  Rng rng(1);
  WindowSet positives({8, 8});
  WindowSet negatives({8, 8});
  positives.add(speckle({8, 8}, rng));
  positives.add(cv::Mat(8, 8, CV_8U, cv::Scalar(40)));
  negatives.add(speckle({8, 8}, rng));
  const auto features = enumerate_features(FeatureSet::kBasic, {8, 8});
  const FeatureTable table(features, positives, negatives, 1U << 20U, 1);
  EXPECT_EQ(table.positives(), 1U);
  EXPECT_EQ(table.samples(), 2U);
  EXPECT_THROW((void)best_stump(table, {1.0}, BoostType::kGentle, 1), InvalidArgument);
  EXPECT_THROW((void)best_stump(table, {1.0, -1.0}, BoostType::kGentle, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
