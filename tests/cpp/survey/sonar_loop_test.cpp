#include "ssjs/survey/sonar_loop.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <variant>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

/// 60 m straight on, a stone every 8 m to each side.
Scenario short_path() {
  Scenario scenario;
  scenario.config = aekf_loop_config();
  scenario.world.waypoints = {{0.0, 0.0}, {60.0, 0.0}};
  scenario.world.landmarks_m.resize(2, 16);
  for (int i = 0; i < 16; ++i) {
    scenario.world.landmarks_m.col(i) << 8.0 * (i / 2), i % 2 == 0 ? 9.0 : -11.0;
    scenario.world.ids.push_back(i);
  }
  return scenario;
}

SonarLoopConfig without_spots() {
  SonarLoopConfig config;
  config.spots_per_100_m2 = 0.0;
  return config;
}

/// Squared errors of the observations against the truth by their own covariances, 2 degrees of freedom each.
double mean_nis(const SonarLoopMission& made, double step_s) {
  double sum = 0.0;
  int count = 0;
  for (const Event& event : made.mission.events) {
    const auto* scan = std::get_if<Features>(&event.record);
    if (scan == nullptr) continue;
    const Se2 global_T_vehicle = made.mission.global_T_vehicle[static_cast<std::size_t>(std::lround(event.time_s / step_s)) - 1];
    for (const Feature& feature : *scan) {
      if (!feature.landmark_id) continue;
      const Eigen::Vector2d truth = made.mission.world.landmarks_m.col(*feature.landmark_id);
      const Eigen::Vector2d expected = predict_range_bearing(global_T_vehicle, truth).range_bearing;
      const Eigen::Vector2d error(feature.range() - expected.x(), angle_difference(feature.bearing(), expected.y()));
      sum += error.dot(feature.covariance.llt().solve(error));
      ++count;
    }
  }
  EXPECT_GT(count, 1000);
  return sum / count;
}

TEST(SonarLoopTest, Q5_ObservationsAreAsGoodAsTheyClaim) {
  const Scenario scenario = short_path();
  const SonarLoopMission made = simulate_sonar_loop(scenario, without_spots(), 3);
  EXPECT_EQ(made.counts.pictures, 200);  // 60 m at 3 m/s, ten a second
  EXPECT_GT(static_cast<double>(made.counts.of_landmarks), 0.95 * static_cast<double>(made.counts.regions));
  EXPECT_EQ(made.counts.of_spots, 0);
  // About 2000 of 2 degrees of freedom: their mean scatters by 0.045 about 2. Cut and merged regions make it a little more.
  const double nis = mean_nis(made, scenario.config.step_s);
  EXPECT_GT(nis, 1.8);
  EXPECT_LT(nis, 2.4);
}

TEST(SonarLoopTest, CountsAndIdentitiesAgree) {
  const Scenario scenario = short_path();
  const SonarLoopMission made = simulate_sonar_loop(scenario, {}, 5);
  std::int64_t regions = 0, of_landmarks = 0, unknown = 0;
  for (const Event& event : made.mission.events) {
    const auto* scan = std::get_if<Features>(&event.record);
    if (scan == nullptr) continue;
    for (const Feature& feature : *scan) {
      ++regions;
      if (!feature.landmark_id) ++unknown;
      if (feature.landmark_id.value_or(16) < 16) ++of_landmarks;
    }
  }
  EXPECT_EQ(made.counts.regions, regions);
  EXPECT_EQ(made.counts.of_nothing, unknown);
  EXPECT_GE(made.counts.of_landmarks, of_landmarks);  // a region of both may be named after a spot
  EXPECT_EQ(made.counts.regions, made.counts.of_landmarks + made.counts.of_spots + made.counts.of_nothing);
  ASSERT_GE(made.mission.world.ids.size(), 16U);
  EXPECT_EQ(made.mission.world.ids.size(), static_cast<std::size_t>(made.mission.world.landmarks_m.cols()));
}

TEST(SonarLoopTest, MaximumEntropySeesMoreSpotsThanTheImprovedOtsuThreshold) {
  SonarLoopConfig config;
  const SonarLoopMission otsu = simulate_sonar_loop(short_path(), config, 2);
  config.segmentation.method = ThresholdMethod::kMaximumEntropy;
  const SonarLoopMission entropy = simulate_sonar_loop(short_path(), config, 2);
  EXPECT_EQ(otsu.counts.second_passes, otsu.counts.pictures);
  EXPECT_GT(otsu.counts.threshold_sum, entropy.counts.threshold_sum);
  EXPECT_GT(entropy.counts.of_spots, 2 * otsu.counts.of_spots);
  EXPECT_GT(entropy.counts.merged, otsu.counts.merged);
}

TEST(SonarLoopTest, TheSameSeedGivesTheSameMission) {
  const SonarLoopMission one = simulate_sonar_loop(short_path(), {}, 9), other = simulate_sonar_loop(short_path(), {}, 9);
  ASSERT_EQ(one.mission.events.size(), other.mission.events.size());
  for (std::size_t i = 0; i < one.mission.events.size(); ++i) {
    const auto* a = std::get_if<Features>(&one.mission.events[i].record);
    const auto* b = std::get_if<Features>(&other.mission.events[i].record);
    ASSERT_EQ(a == nullptr, b == nullptr);
    if (a == nullptr) continue;
    ASSERT_EQ(a->size(), b->size());
    for (std::size_t k = 0; k < a->size(); ++k) EXPECT_EQ((*a)[k].range_bearing, (*b)[k].range_bearing);
  }
}

TEST(SonarLoopTest, EveryViolationIsNamed) {
  SonarLoopConfig config;
  config.picture.max_range_m = 0.5;
  config.brightest_spot_level = 50.0;
  config.segmentation.filter.median_px = 4;
  EXPECT_EQ(config.violations().size(), 3U);
  EXPECT_THROW((void)simulate_sonar_loop(short_path(), config, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
