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

}  // namespace
}  // namespace ssjs
