#include "ssjs/survey/object_centre.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/simulation/seabed.hpp"

namespace ssjs {
namespace {

/// What an object of that shape, broadside on at ground range c, shows a sonar h above its foot: ranges of its first and last echo
/// and of its shadow's tip, from its profile in steps of a millimetre.
ObjectRanges ranges_of(ObjectShape shape, double c, double h, double width_m, double height_m) {
  SeabedObject object;
  object.shape = shape;
  object.position_m = {0, c};
  object.length_m = 2;
  object.width_m = width_m;
  object.height_m = height_m;
  ObjectRanges ranges{h, 1e9, 0, 0};
  double steepest = 1e9;  // least h / y so far: what has more is hidden
  for (double y = c - 0.5 * width_m; y <= c + 0.5 * width_m; y += 0.001) {
    const double below_m = h - object.height_at({0, y});
    if (below_m / y > steepest) continue;
    steepest = below_m / y;
    ranges.near_m = std::min(ranges.near_m, std::hypot(y, below_m));
    ranges.behind_m = std::hypot(y, below_m);
  }
  ranges.tip_m = std::hypot(h / steepest, h);
  return ranges;
}

TEST(ObjectCentreTest, SS18_TheLastEchoIsPlacedExactlyWhateverTheShape) {
  // A post 1 m high at 12 m, 5 m below: nothing lies behind its top, and the near edge is taken for the same. (SS-34) takes the sound
  // for plane over the height of an object, which here is an error of H^2 cos^2 / 2r = 0.036 m in its reach.
  const double top_m = std::hypot(12.0, 4.0);
  const ObjectCentre post = centre_of_object({5, top_m, top_m, std::hypot(15.0, 5.0)});
  EXPECT_NEAR(post.height_m, 1.0, 1e-12);
  EXPECT_NEAR(post.ground_range_m, 12.0, 0.036);
  EXPECT_LT(post.sigma_m, 0.036);
}

TEST(ObjectCentreTest, SS35_UnbiasedOverShapesWithASigmaThatCoversEach) {
  for (const double range_m : {6.0, 10.0, 15.0, 20.0, 26.0}) {
    double sum = 0;
    double squares = 0;
    for (const auto& [name, shape] : kObjectShapes) {
      const ObjectCentre centre = centre_of_object(ranges_of(shape, range_m, 4.5, 1.2, 0.6));
      const double error_m = centre.ground_range_m - range_m;
      sum += error_m;
      squares += std::pow(error_m / centre.sigma_m, 2);
      EXPECT_LT(std::abs(error_m), 0.25) << name << " at " << range_m;
      EXPECT_GT(centre.height_m, 0.55 * 0.6) << name;
      EXPECT_LT(centre.height_m, 0.6 + 1e-3) << name;
    }
    EXPECT_LT(std::abs(sum / 4), 0.05) << range_m;
    EXPECT_LT(squares / 4, 2.0) << range_m;
    EXPECT_GT(squares / 4, 0.3) << range_m;
  }
}

TEST(ObjectCentreTest, ABoxIsSeenAtHalfItsWidthBehindItsNearUpperEdge) {
  // the widest top: 1.2 m behind the edge at 15 m; the mean over shapes lies behind the middle, by less than a quarter of the width
  const ObjectCentre box = centre_of_object(ranges_of(ObjectShape::kBox, 15.6, 5, 1.2, 0.8));
  EXPECT_GT(box.ground_range_m, 15.6);
  EXPECT_LT(box.ground_range_m, 15.9);
}

TEST(ObjectCentreTest, ImpossibleRangesAreRefused) {
  EXPECT_THROW(static_cast<void>(centre_of_object({5, 6, 4.9, 7})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(centre_of_object({5, 6, 8, 7})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(centre_of_object({0, 6, 8, 9})), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
