#include "ssjs/cascade/detection_grouping.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(DetectionGroupingTest, C15_AGroupIsTheMeanOfItsBoxesWithTheBestScore) {
  // Sides differ by at most 4 = 0.2 x 20; the fourth box stands apart.
  const std::vector<WindowHit> hits = {{{10, 10, 20, 20}, 1}, {{12, 10, 20, 20}, 3}, {{14, 13, 20, 20}, 2}, {{60, 60, 20, 20}, 9}};
  const auto detections = group_hits(hits, 2, 0.2);
  ASSERT_EQ(detections.size(), 1U);
  EXPECT_EQ(detections[0].box, cv::Rect(12, 11, 20, 20));
  EXPECT_EQ(detections[0].score, 3);
  EXPECT_EQ(detections[0].neighbours, 3);
}

TEST(DetectionGroupingTest, C15_ChainsHangTogether) {
  std::vector<WindowHit> hits;
  for (int i = 0; i < 10; ++i) hits.push_back({{4 * i, 0, 20, 20}, 0.1 * i});  // first and last are 36 apart
  ASSERT_EQ(group_hits(hits, 3, 0.2).size(), 1U);
  EXPECT_EQ(group_hits(hits, 3, 0.2)[0].box, cv::Rect(18, 0, 20, 20));
  EXPECT_TRUE(group_hits(hits, 3, 0.1).empty());
}

TEST(DetectionGroupingTest, C15_ASmallGroupInsideALargerOneOfMoreWindowsIsDropped) {
  std::vector<WindowHit> hits(5, {{0, 0, 60, 60}, 1});
  hits.insert(hits.end(), 2, {{20, 20, 20, 20}, 2});
  const auto detections = group_hits(hits, 1, 0.2);
  ASSERT_EQ(detections.size(), 1U);
  EXPECT_EQ(detections[0].neighbours, 5);
}

TEST(DetectionGroupingTest, WithoutNeighboursEveryHitStandsBestFirst) {
  const auto detections = group_hits({{{0, 0, 9, 9}, 1}, {{1, 0, 9, 9}, 5}, {{0, 0, 9, 9}, 3}}, 0, 0.2);
  ASSERT_EQ(detections.size(), 3U);
  EXPECT_EQ(detections[0].score, 5);
  EXPECT_EQ(detections[2].score, 1);
  EXPECT_THROW((void)group_hits({}, -1, 0.2), InvalidArgument);
  EXPECT_TRUE(group_hits({}, 3, 0.2).empty());
}

TEST(DetectionGroupingTest, C26_TheBestHitTakesThoseThatItOverlaps) {
  // 20 x 20 each: the second shares 320 of 400 with the best, the third 100, the fourth nothing.
  const std::vector<WindowHit> hits = {{{0, 0, 20, 20}, 3}, {{4, 0, 20, 20}, 1}, {{15, 0, 20, 20}, 2}, {{60, 60, 20, 20}, 9}};
  const auto detections = best_hits(hits, 0, 0.5);
  ASSERT_EQ(detections.size(), 3U);
  EXPECT_EQ(detections[0].box, cv::Rect(60, 60, 20, 20));
  EXPECT_EQ(detections[1].box, cv::Rect(1, 0, 20, 20));  // (3 x 0 + 1 x 4) / 4
  EXPECT_EQ(detections[1].score, 3);
  EXPECT_EQ(detections[1].neighbours, 2);
  EXPECT_EQ(detections[2].box, cv::Rect(15, 0, 20, 20));
  EXPECT_EQ(best_hits(hits, 1, 0.5).size(), 1U);
  EXPECT_EQ(best_hits(hits, 0, 0.2).size(), 2U);
}

TEST(DetectionGroupingTest, C26_ChainsDoNotHangTogetherAndSmallHitsInsideBelongToTheBest) {
  std::vector<WindowHit> chain;
  for (int i = 0; i < 10; ++i) chain.push_back({{8 * i, 0, 20, 20}, 10.0 - i});
  EXPECT_EQ(best_hits(chain, 0, 0.5).size(), 5U);  // each takes its neighbour alone
  const auto nested = best_hits({{{0, 0, 60, 60}, 2}, {{20, 20, 20, 20}, 1}}, 0, 0.5);
  ASSERT_EQ(nested.size(), 1U);
  EXPECT_EQ(nested[0].box, cv::Rect(0, 0, 60, 60));  // too unlike to have a say in the mean
  EXPECT_EQ(best_hits({{{3, 3, 9, 9}, 0}, {{3, 3, 9, 9}, 0}}, 0, 1.0).size(), 1U);
  EXPECT_THROW((void)best_hits({}, -1, 0.5), InvalidArgument);
  EXPECT_THROW((void)best_hits({}, 0, 1.5), InvalidArgument);
  EXPECT_TRUE(best_hits({}, 0, 0.5).empty());
}

}  // namespace
}  // namespace ssjs
