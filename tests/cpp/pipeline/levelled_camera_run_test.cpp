// A survey with a camera from its frames to the closed loop. docs/math/camera.md
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mapping/camera_run.hpp"
#include "ssjs/pipeline/levelled_run.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

/// Twice around a square of 40 m, over the same seabed.
CameraMission two_laps() {
  CameraMission mission = camera_mission();
  mission.waypoints = {{0.0, 0.0}, {12.0, 0.0}, {12.0, 8.0}, {0.0, 8.0}, {0.0, 0.0}, {12.0, 0.0}, {12.0, 8.0}};
  mission.clutter = 3;
  mission.simulation.velocity_time_constant_s = 20.0;  // keeps its speed
  return mission;
}

/// With a compass and a velocity log three times as bad.
CameraMission two_bad_laps() {
  CameraMission mission = two_laps();
  mission.simulation.compass.sigma_rad = 0.05;
  mission.simulation.velocity_log.sigma_m_s = 0.05;
  return mission;
}

LevelledConfig config_of(const CameraMission& mission) {
  LevelledConfig config;
  config.local = matched(mission);
  config.local.association.method = AssociationMethod::kJointCompatibility;
  config.local.split.policy.max_distance_m = 10.0;
  return config;
}

struct Quality {
  double rmse_m = 0.0, dead_reckoning_m = 0.0, inside = 0.0;
  double nees = 0.0;  ///< of the bases together, per degree of freedom
  int dof = 0;
};

Quality quality_of(const LevelledResult& result, const SimulatedSurvey& survey) {
  Quality quality;
  const Se2 start_T_world = level_pose(survey.truth.front()).inverse();
  int inside = 0;
  for (Eigen::Index i = 0; i < result.time_s.size(); ++i) {
    const Se2 truth = start_T_world * level_pose(truth_at(survey, result.time_s(i)));
    const Eigen::Vector2d error = result.pose.row(i).head<2>().transpose() - truth.translation();
    quality.rmse_m += error.squaredNorm();
    quality.dead_reckoning_m += (result.dead_reckoning.row(i).head<2>().transpose() - truth.translation()).squaredNorm();
    const double heading = angle_difference(result.pose(i, 5), truth.heading);
    const bool holds = std::abs(error.x()) <= 3.0 * std::sqrt(result.covariance(i, 0)) &&
                       std::abs(error.y()) <= 3.0 * std::sqrt(result.covariance(i, 6)) &&
                       std::abs(heading) <= 3.0 * std::sqrt(result.covariance(i, 20));
    inside += holds ? 1 : 0;
  }
  const auto n = static_cast<double>(result.time_s.size());
  quality.rmse_m = std::sqrt(quality.rmse_m / n);
  quality.dead_reckoning_m = std::sqrt(quality.dead_reckoning_m / n);
  quality.inside = inside / n;
  const auto bases = static_cast<Eigen::Index>(result.global_T_base.size());
  Eigen::VectorXd error(3 * bases - 3);
  for (Eigen::Index k = 1; k < bases; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double time_s = at < result.submaps.size() ? result.submaps[at].start_time_s : result.submaps.back().end_time_s;
    const Se2 truth = start_T_world * level_pose(truth_at(survey, time_s));
    const Se2& base = result.global_T_base[at].mean;
    error.segment<3>(3 * k - 3) << truth.x - base.x, truth.y - base.y, angle_difference(truth.heading, base.heading);
  }
  quality.nees = normalized_squared_error(error, result.base_covariance.bottomRightCorner(error.size(), error.size())) /
                 static_cast<double>(error.size());
  quality.dof = static_cast<int>(error.size());
  return quality;
}

/// Landmarks that maps of both laps have in common.
int met_again(const LevelledResult& result) {
  return static_cast<int>(std::count_if(result.landmarks.begin(), result.landmarks.end(),
                                        [](const SurveyLandmark& landmark) { return landmark.maps.back() - landmark.maps.front() > 4; }));
}

/// The same places, which look different on the way back: position alone would pair them.
TEST(LevelledCameraRun, I15_WhatLooksDifferentClosesNothing) {
  const CameraMission mission = two_laps();
  CameraSurvey made = simulate_camera(mission, 4);
  const double repainted_s = 0.55 * made.survey.ticks.back().time_s;
  for (NavigationTick& tick : made.survey.ticks) {
    if (!tick.frame || tick.time_s < repainted_s) continue;
    for (CameraSighting& sighting : tick.frame->sightings) sighting.descriptor.reverseInPlace();
  }
  LevelledConfig config = config_of(mission);
  const LevelledResult result = run_levelled_mission(config, made.survey.ticks);
  EXPECT_GT(result.submaps.size(), 6U);
  EXPECT_EQ(met_again(result), 0);
  config.joining.max_descriptor_distance = 2.0;
  EXPECT_GT(met_again(run_levelled_mission(config, made.survey.ticks)), 10);
}

/// Bounds on the NEES of the bases per degree of freedom, and on the part of the time within three sigma.
void expect_consistent(const CameraMission& mission, double most_nees, double least_inside) {
  constexpr int kRuns = 20;
  double inside = 0.0, nees = 0.0, rmse_m = 0.0, dead_reckoning_m = 0.0;
  int closures = 0, wrong = 0, dof = 0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const CameraSurvey made = simulate_camera(mission, seed);
    const LevelledResult result = run_levelled_mission(config_of(mission), made.survey.ticks);
    const Quality quality = quality_of(result, made.survey);
    inside += quality.inside / kRuns;
    rmse_m += quality.rmse_m / kRuns;
    dead_reckoning_m += quality.dead_reckoning_m / kRuns;
    nees += quality.nees * quality.dof;
    dof += quality.dof;
    closures += result.loop_closures;
    wrong += result.map_wrong_pairs;
  }
  std::printf(
      "%d closures, %d wrong pairs; RMSE %.3f m, dead reckoning %.3f m; inside three sigma %.3f; NEES of the bases per dof %.3f (%d)\n",
      closures, wrong, rmse_m, dead_reckoning_m, inside, nees / dof, dof);
  EXPECT_GE(inside, least_inside);
  EXPECT_LT(nees / dof, most_nees);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(closures, 5 * kRuns);
}

TEST(LevelledCameraRun, I15_ConsistentOver20LoopsLong) { expect_consistent(two_laps(), 1.2, 0.99); }
TEST(LevelledCameraRun, I15_ABadLogIsALittleOptimisticLong) { expect_consistent(two_bad_laps(), 1.3, 0.85); }

TEST(LevelledCameraRun, I15_ARevisitClosesTheLoop) {
  const CameraMission mission = two_laps();
  const CameraSurvey made = simulate_camera(mission, 4);
  const LevelledResult result = run_levelled_mission(config_of(mission), made.survey.ticks);
  const Quality quality = quality_of(result, made.survey);
  const auto camera = static_cast<std::size_t>(NavigationSensor::kCamera);
  std::printf(
      "%zu maps, %d closures, %d wrong pairs in maps and %d between, %zu landmarks; RMSE %.3f m, dead reckoning %.3f m, %.3f inside\n",
      result.submaps.size(), result.loop_closures, result.scan_wrong_pairs, result.map_wrong_pairs, result.landmarks.size(), quality.rmse_m,
      quality.dead_reckoning_m, quality.inside);
  std::printf("camera: used %d, refused %d; total %.2f s, association %.2f s, global %.2f s, of %.0f s\n", result.sensors[camera].used,
              result.sensors[camera].refused, result.time_total_s, result.time_association_s, result.time_global_s,
              made.survey.ticks.back().time_s);
  EXPECT_GT(result.submaps.size(), 6U);
  EXPECT_GT(met_again(result), 30);
  EXPECT_EQ(result.map_wrong_pairs, 0);
  EXPECT_LT(quality.rmse_m, quality.dead_reckoning_m / 3.0);
  EXPECT_GE(quality.inside, 0.95);
  EXPECT_EQ(result.budget_exhausted, 0);
  EXPECT_EQ(result.frame_sightings.size(), static_cast<std::size_t>(result.sensors[camera].used));
  for (const SurveyLandmark& landmark : result.landmarks) EXPECT_TRUE(landmark.confirmed);
}

}  // namespace
}  // namespace ssjs
