#include "ssjs/joining/landmark_list.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

LandmarkEstimate landmark(double x, double variance, int times_seen) {
  return {{{x, 0.0}, variance * Eigen::Matrix2d::Identity()}, {times_seen, std::nullopt}, 0};
}

TEST(LandmarkList, TheSurestCopyStandsForAllWithTheirSightings) {
  const std::vector<LandmarkEstimate> all{landmark(0, 3, 1), landmark(1, 1, 2), landmark(2, 2, 4), landmark(3, 1, 8), landmark(4, 5, 16)};
  const std::vector<LandmarkEstimate> once = listed_once(all, {{4, 2}, {0, 2}, {2, 0}});  // 0, 2 and 4 are one, over two steps
  ASSERT_EQ(once.size(), 3U);
  EXPECT_EQ(once[0].position.mean.x(), 2.0);
  EXPECT_EQ(once[0].landmark.times_seen, 21);
  EXPECT_EQ(once[1].position.mean.x(), 1.0);
  EXPECT_EQ(once[2].position.mean.x(), 3.0);
}

TEST(LandmarkList, OnlyMapsThatOverlapAreAsked) {
  Rng rng(551);
  std::map<int, LiveMap> maps;
  std::map<int, std::size_t> first_of;
  for (const int base : {0, 3, 8}) {
    LiveMap map = testing::random_map(rng, base, {base + 1}, 1, 2, 0.1);
    map.centroid.setZero();
    map.radius = 5.0;
    first_of[base] = static_cast<std::size_t>(10 * base);
    maps.emplace(base, map);
  }
  const auto pose = [](int base) { return Se2{3.0 * base, 0.0, 0.0}; };  // 0, 9 and 24 m
  int asked = 0;
  const std::vector<SameLandmark> same = common_landmarks(maps, first_of, pose, [&](const LiveMap& a, const LiveMap& b) {
    EXPECT_EQ(a.base, 0);
    EXPECT_EQ(b.base, 3);
    ++asked;
    return std::vector<Pair>{{1, 0}};
  });
  EXPECT_EQ(asked, 1);
  const std::vector<SameLandmark> expected{{0, 31}};
  EXPECT_EQ(same, expected);
}

}  // namespace
}  // namespace ssjs
