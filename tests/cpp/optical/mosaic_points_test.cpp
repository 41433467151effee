#include "ssjs/optical/mosaic_points.hpp"

#include <gtest/gtest.h>

#include <map>

#include "ssjs/base/error.hpp"
#include "ssjs/optical/matching.hpp"

namespace ssjs {
namespace {

const cv::Size kFrame(160, 120);

cv::Matx33d shifted(double x, double y) { return {1, 0, x, 0, 1, y, 0, 0, 1}; }

TEST(MosaicPointsTest, V25_PointsAreSeenWhereTheRegistrationsTakeThem) {
  // three frames in a row on the map; the registration of 0 and 1 is 2 px off what the map says, 0 and 2 were never registered
  const std::vector<cv::Matx33d> placed{shifted(0, 0), shifted(60, 0), shifted(120, 0)};
  const std::vector<FrameHomography> links{{0, 1, shifted(-58, 0)}, {1, 2, shifted(-60, 0)}};
  const auto sightings = mosaic_points(placed, kFrame, links, 400, 7);
  std::map<int, std::map<int, cv::Point2d>> of_point;
  for (const MosaicPointSighting& sighting : sightings) of_point[sighting.point][sighting.frame] = sighting.pixel;
  EXPECT_EQ(of_point.size(), 400U);
  int in_first_two = 0;
  for (const auto& [point, seen] : of_point) {
    if (seen.count(0) != 0 && seen.count(1) != 0) {
      EXPECT_NEAR(seen.at(1).x - seen.at(0).x, -58.0, 1e-9);
      ++in_first_two;
    }
    if (seen.count(1) != 0 && seen.count(2) != 0) {
      EXPECT_NEAR(seen.at(2).x - seen.at(1).x, -60.0, 1e-9);
    }
    for (const auto& [frame, pixel] : seen) {
      EXPECT_TRUE(pixel.x > 0 && pixel.x < 159 && pixel.y > 0 && pixel.y < 119);
    }
  }
  EXPECT_GT(in_first_two, 50);
  const auto again = mosaic_points(placed, kFrame, links, 400, 7);
  ASSERT_EQ(again.size(), sightings.size());
  EXPECT_EQ(again.back().pixel, sightings.back().pixel);
  EXPECT_NE(mosaic_points(placed, kFrame, links, 400, 8).back().pixel, sightings.back().pixel);
}

TEST(MosaicPointsTest, FramesThatAreNotThereAreRefused) {
  EXPECT_THROW((void)mosaic_points({}, kFrame, {}, 5, 1), InvalidArgument);
  EXPECT_THROW((void)mosaic_points({shifted(0, 0)}, kFrame, {{0, 1, shifted(0, 0)}}, 5, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
