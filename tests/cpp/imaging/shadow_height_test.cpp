#include "ssjs/imaging/shadow_height.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(ShadowHeightTest, R15_SimilarTriangles) {
  // The sonar 10 m up, the tip 40 m away: the ray falls 1 m in 4 m, and an object 8 m before the tip is 2 m high.
  EXPECT_DOUBLE_EQ(height_from_shadow_m(10, 32, 40, ShadowRanges::kGround), 2.0);
  EXPECT_EQ(height_from_shadow_m(10, 40, 40, ShadowRanges::kGround), 0.0);
}

TEST(ShadowHeightTest, R16_R17_SlantRangesOfABoxAndOfAPost) {
  const double altitude = 12.0;
  for (const double height : {0.5, 2.0, 6.0}) {
    for (const double caster_m : {5.0, 20.0, 60.0}) {
      const double tip_m = caster_m * altitude / (altitude - height);  // the ray over the top comes down here
      const double slant_tip = std::hypot(tip_m, altitude);
      const double slant_top = std::hypot(caster_m, altitude - height);
      const double slant_foot = std::hypot(caster_m, altitude);
      EXPECT_NEAR(height_from_shadow_m(altitude, caster_m, tip_m, ShadowRanges::kGround), height, 1e-12);
      EXPECT_NEAR(height_from_shadow_m(altitude, slant_top, slant_tip, ShadowRanges::kSlantTop), height, 1e-12);
      EXPECT_NEAR(height_from_shadow_m(altitude, slant_foot, slant_tip, ShadowRanges::kSlantFoot), height, 1e-12);
    }
  }
}

TEST(ShadowHeightTest, R17_GroundRange) {
  EXPECT_DOUBLE_EQ(ground_range_m(5, 3), 4.0);
  EXPECT_EQ(ground_range_m(3, 3), 0.0);
  EXPECT_THROW(static_cast<void>(ground_range_m(2.9, 3)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(ground_range_m(5, -1)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(ground_range_m(std::nan(""), 1)), InvalidArgument);
}

TEST(ShadowHeightTest, ImpossibleShadowsAreRefused) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(0, 1, 2, ShadowRanges::kGround)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 41, 40, ShadowRanges::kGround)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, -1, 40, ShadowRanges::kGround)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 0, 0, ShadowRanges::kGround)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 1, kInfinity, ShadowRanges::kGround)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 5, 9, ShadowRanges::kSlantTop)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 5, 12, ShadowRanges::kSlantFoot)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(height_from_shadow_m(10, 10, 10, ShadowRanges::kSlantFoot)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
