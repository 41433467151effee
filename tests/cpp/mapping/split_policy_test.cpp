#include "ssjs/mapping/split_policy.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/config_field.hpp"

namespace ssjs {
namespace {

/// Everything switched off, so that a test switches on what it is about.
SplitPolicyConfig nothing() { return {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 0}; }

SplitSituation moved() {
  SplitSituation now;
  now.landmarks = 10;
  now.distance_m = 5.0;
  now.duration_s = 3.0;
  now.submap_T_vehicle.covariance = Eigen::Vector3d(0.04, 0.01, 0.0004).asDiagonal();
  return now;
}

TEST(SplitPolicy, C1_NothingConfiguredNeverCloses) {
  SplitSituation now = moved();
  now.landmarks = now.new_landmarks = 1000;
  now.distance_m = now.duration_s = 1e6;
  now.submap_T_vehicle.covariance *= 1e6;
  EXPECT_EQ(reason_to_close(now, nothing()), std::nullopt);
}

TEST(SplitPolicy, C1_LandmarksCloseWhenTheNewOnesWouldExceedTheLimit) {
  SplitPolicyConfig config = nothing();
  config.max_landmarks = 12;
  SplitSituation now = moved();
  now.new_landmarks = 2;
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);  // 10 + 2 = 12 still fit
  now.new_landmarks = 3;
  EXPECT_EQ(reason_to_close(now, config), "landmarks");
  now.landmarks = 20;  // more than allowed, but this scan brings nothing new: the map is only revisited
  now.new_landmarks = 0;
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
}

TEST(SplitPolicy, C1_PositionUncertaintyIsTheLargestAxisOfTheEllipse) {
  SplitPolicyConfig config = nothing();
  config.max_sigma_xy_m = 1.0;
  SplitSituation now = moved();
  // Variances 0.6 and 0.6 with covariance 0.45: eigenvalues 1.05 and 0.15. No diagonal entry alone exceeds 1.
  now.submap_T_vehicle.covariance.topLeftCorner<2, 2>() << 0.6, 0.45, 0.45, 0.6;
  EXPECT_EQ(reason_to_close(now, config), "position uncertainty");
  now.submap_T_vehicle.covariance.topLeftCorner<2, 2>() << 0.6, 0.35, 0.35, 0.6;  // 0.95
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
}

TEST(SplitPolicy, C1_HeadingUncertainty) {
  SplitPolicyConfig config = nothing();
  config.max_sigma_heading_rad = 0.02;
  SplitSituation now = moved();
  now.submap_T_vehicle.covariance(2, 2) = 0.0199 * 0.0199;
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
  now.submap_T_vehicle.covariance(2, 2) = 0.0201 * 0.0201;
  EXPECT_EQ(reason_to_close(now, config), "heading uncertainty");
}

TEST(SplitPolicy, C1_Distance) {
  SplitPolicyConfig config = nothing();
  config.max_distance_m = 5.0;
  SplitSituation now = moved();
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
  now.distance_m = 5.01;
  EXPECT_EQ(reason_to_close(now, config), "distance");
}

TEST(SplitPolicy, C1_Duration) {
  SplitPolicyConfig config = nothing();
  config.max_duration_s = 3.0;
  SplitSituation now = moved();
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
  now.duration_s = 3.01;
  EXPECT_EQ(reason_to_close(now, config), "duration");
}

TEST(SplitPolicy, C1_PoorMapsAreClosedByTheirLandmarksOnly) {
  SplitPolicyConfig config = nothing();
  config.min_landmarks = 3;
  config.max_landmarks = 4;
  config.max_distance_m = 1.0;
  SplitSituation now = moved();
  now.landmarks = 2;
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
  now.new_landmarks = 3;
  EXPECT_EQ(reason_to_close(now, config), "landmarks");
  now.new_landmarks = 0;
  now.landmarks = 3;
  EXPECT_EQ(reason_to_close(now, config), "distance");
}

TEST(SplitPolicy, C1_AVehicleThatStoodStillGivesNoLink) {
  SplitPolicyConfig config = nothing();
  config.max_landmarks = 3;
  config.max_duration_s = 1.0;
  SplitSituation now = moved();
  now.new_landmarks = 100;
  now.duration_s = 100.0;
  now.distance_m = 0.0;
  EXPECT_EQ(reason_to_close(now, config), std::nullopt);
}

}  // namespace
}  // namespace ssjs
