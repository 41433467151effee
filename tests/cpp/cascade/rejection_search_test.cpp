#include "ssjs/cascade/rejection_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "cascade/search_problem.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

struct Rates {
  std::size_t objects_lost = 0;
  std::size_t negatives_passed = 0;
};

Rates rates_of(const Stump& stump, const FeatureTable& table, const std::vector<unsigned char>& standing) {
  std::vector<float> values(table.samples());
  table.values(stump.feature, values.data());
  Rates rates;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (standing[i] == 0) continue;
    const bool passes = (values[i] < stump.threshold) == (stump.left > stump.right);
    if (i < table.positives()) rates.objects_lost += passes ? 0 : 1;
    if (i >= table.positives()) rates.negatives_passed += passes ? 1 : 0;
  }
  return rates;
}

/// Every feature, either side, every value of an object as the last one that passes.
std::size_t fewest_passed(const FeatureTable& table, const std::vector<unsigned char>& standing, std::size_t lost) {
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  std::vector<float> values(table.samples());
  for (std::size_t f = 0; f < table.features(); ++f) {
    table.values(f, values.data());
    for (const float sign : {1.0F, -1.0F}) {
      std::vector<float> objects;
      for (std::size_t i = 0; i < table.positives(); ++i)
        if (standing[i] != 0) objects.push_back(sign * values[i]);
      std::sort(objects.begin(), objects.end());
      std::size_t passed = 0;
      for (std::size_t i = table.positives(); i < table.samples(); ++i)
        passed += standing[i] != 0 && sign * values[i] >= objects[lost] ? 1 : 0;
      fewest = std::min(fewest, passed);
    }
  }
  return fewest;
}

TEST(RejectionSearchTest, C21_NoOtherStumpRejectsMoreAtTheSameLoss) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Problem problem = make_problem({9, 9}, FeatureSet::kAll, 60, 90, seed);
    const FeatureTable table(problem.features, problem.positives, problem.negatives, 1U << 24U, 1);
    std::vector<unsigned char> standing(table.samples(), 1);
    Rng rng(seed);
    for (unsigned char& one : standing) one = rng.below(5) == 0 ? 0 : 1;
    for (const std::size_t lost : {0U, 1U, 7U}) {
      const auto stump = best_rejection(table, standing, lost, 1);
      ASSERT_TRUE(stump);
      const Rates rates = rates_of(*stump, table, standing);
      EXPECT_LE(rates.objects_lost, lost);
      EXPECT_EQ(rates.negatives_passed, fewest_passed(table, standing, lost));
    }
  }
}

TEST(RejectionSearchTest, SameStumpOnAnyNumberOfThreadsWithAnyMemory) {
  const Problem problem = make_problem({12, 12}, FeatureSet::kSideScanBasic, 80, 120, 4);
  const std::vector<unsigned char> standing(200, 1);
  const FeatureTable kept(problem.features, problem.positives, problem.negatives, 1U << 28U, 1);
  const FeatureTable not_kept(problem.features, problem.positives, problem.negatives, 1U << 10U, 1);
  const auto expected = best_rejection(kept, standing, 2, 1);
  ASSERT_TRUE(expected);
  for (const auto& found :
       {best_rejection(kept, standing, 2, 2), best_rejection(kept, standing, 2, 5), best_rejection(not_kept, standing, 2, 2)}) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->feature, expected->feature);
    EXPECT_EQ(found->threshold, expected->threshold);
    EXPECT_EQ(found->left, expected->left);
    EXPECT_EQ(found->right, expected->right);
  }
}

TEST(RejectionSearchTest, NothingToRejectOrNobodyToKeep) {
  const Problem problem = make_problem({9, 9}, FeatureSet::kSideScan, 5, 5, 5);
  const FeatureTable table(problem.features, problem.positives, problem.negatives, 1U << 20U, 1);
  EXPECT_FALSE(best_rejection(table, std::vector<unsigned char>(10, 1), 5, 1));
  EXPECT_FALSE(best_rejection(table, {1, 1, 1, 1, 1, 0, 0, 0, 0, 0}, 0, 1));
  EXPECT_THROW((void)best_rejection(table, {1, 1}, 0, 1), InvalidArgument);
}

TEST(RejectionSearchTest, IdenticalWindowsAreNotToldApart) {
  Rng rng(6);
  WindowSet windows({9, 9});
  const cv::Mat picture = speckle({9, 9}, rng);
  for (int i = 0; i < 6; ++i) windows.add(picture);
  const auto features = enumerate_features(FeatureSet::kSideScan, {9, 9});
  const FeatureTable table(features, windows, windows, 1U << 20U, 1);
  EXPECT_FALSE(best_rejection(table, std::vector<unsigned char>(12, 1), 0, 1));
}

}  // namespace
}  // namespace ssjs
