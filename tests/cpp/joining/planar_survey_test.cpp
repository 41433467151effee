#include "ssjs/joining/planar_survey.hpp"

#include <gtest/gtest.h>

#include <map>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/planar_submap.hpp"
#include "ssjs/joining/port_survey.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/joining/sequential.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kAllBases = 1000;

MapAssociator by_identity() { return {{AssociationMethod::kKnown, {}, std::nullopt, std::nullopt}, 1}; }
std::unique_ptr<MapJoiner> in_sequence() { return std::make_unique<SequentialJoiner>(by_identity()); }
std::unique_ptr<MapJoiner> selectively_fused() {
  SelectiveJoinerConfig config;
  return std::make_unique<SelectiveJoiner>(config, AssociationMethod::kKnown, std::nullopt, 1);
}

SurveyEstimate joined(SurveyJoiner& joiner, const std::vector<LevelledSubmap>& maps) {
  for (const LevelledSubmap& map : maps) static_cast<void>(joiner.take(map));
  static_cast<void>(joiner.finish());
  return joiner.estimate(kAllBases);
}

TEST(PlanarSurvey, U1_TheMarginalOfExitAndLandmarks) {
  LevelledSubmap map;
  map.index = 4;
  map.compass = CompassPorts::kBorders;
  map.landmarks = {{2, 7, {0}}, {1, std::nullopt, {1}}};
  map.mean.resize(11);
  map.mean << 1, 2, 0.3, 0.7, 0.8, 10, 11, 12, 20, 21, 22;
  map.covariance.resize(11, 11);
  for (Eigen::Index i = 0; i < 11; ++i) {
    for (Eigen::Index j = 0; j < 11; ++j) map.covariance(i, j) = static_cast<double>(100 * std::min(i, j) + std::max(i, j));
  }
  const Submap planar = planar_submap_of(map, 50);
  Eigen::VectorXd mean(7);
  mean << 1, 2, 0.3, 10, 11, 20, 21;
  EXPECT_EQ(planar.state.mean, mean);
  EXPECT_EQ(planar.state.covariance(2, 3), 205.0);  // heading of row 2 with x of the first landmark, row 5
  EXPECT_EQ(planar.state.covariance(4, 6), 609.0);  // y of the first, row 6, with y of the second, row 9
  EXPECT_EQ(planar.index, 4);
  EXPECT_EQ(planar.landmarks[0].source_id, 7);
  EXPECT_EQ(planar.landmarks[0].times_seen, 2);
  EXPECT_EQ(planar.landmarks[0].tracks, std::vector<std::int64_t>{50});
  EXPECT_EQ(planar.landmarks[1].tracks, std::vector<std::int64_t>{51});
}

/// Depths that nothing is correlated with, and errors so small that all is linear, yet large beside what live_map_of() adds to a heading
/// (1e-12 rad^2).
std::vector<LevelledSubmap> small_maps_with_depths_apart(const testing::LevelledWorld& world, Rng& rng) {
  testing::MapNoise noise;
  noise.exit_m *= 1e-2;
  noise.exit_rad *= 1e-2;
  noise.landmark_m *= 1e-2;
  std::vector<LevelledSubmap> maps;
  for (int k = 0; k + 1 < static_cast<int>(world.bases.size()); ++k) {
    const std::vector<int> seen = testing::seen_between(world, k);
    Eigen::MatrixXd P = testing::map_covariance(noise, CompassPorts::kNone, static_cast<Eigen::Index>(seen.size()), rng);
    for (Eigen::Index z = 5; z < P.rows(); z += 3) {
      const double variance = P(z, z);
      P.row(z).setZero();
      P.col(z).setZero();
      P(z, z) = variance;
    }
    maps.push_back(testing::noisy_levelled_submap(world, k, seen, CompassPorts::kNone, P, rng));
  }
  return maps;
}

TEST(PlanarSurvey, U1_U3_WithoutCompassNothingIsLost) {
  Rng rng(5);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const std::vector<LevelledSubmap> maps = small_maps_with_depths_apart(world, rng);
  PortJoinerConfig known;
  known.association = AssociationMethod::kKnown;
  PortSurvey ports(known);
  PlanarSurvey planar(in_sequence(), std::nullopt);
  const SurveyEstimate batch = joined(ports, maps);
  const SurveyEstimate sequence = joined(planar, maps);
  std::map<std::int64_t, SurveyLandmark> by_identity;
  for (const SurveyLandmark& landmark : batch.landmarks) by_identity.emplace(*landmark.landmark.source_id, landmark);
  ASSERT_EQ(sequence.landmarks.size(), batch.landmarks.size());
  int shared = 0;
  for (const SurveyLandmark& landmark : sequence.landmarks) {
    const SurveyLandmark& expected = by_identity.at(*landmark.landmark.source_id);
    EXPECT_EQ(landmark.maps, expected.maps);
    EXPECT_EQ(landmark.landmark.times_seen, expected.landmark.times_seen);
    const double sigma = std::sqrt(expected.covariance.topLeftCorner<2, 2>().trace());
    EXPECT_LT((landmark.position - expected.position).head<2>().norm(), 0.02 * sigma);
    EXPECT_LT(((landmark.covariance - expected.covariance).topLeftCorner<2, 2>().norm()), 0.01 * sigma * sigma);
    EXPECT_NEAR(landmark.position.z(), expected.position.z(), 1e-3 * std::sqrt(expected.covariance(2, 2)));
    EXPECT_NEAR(landmark.covariance(2, 2), expected.covariance(2, 2), 1e-6 * expected.covariance(2, 2));
    if (landmark.maps.size() > 1) ++shared;
  }
  EXPECT_GT(shared, 10);
}

TEST(PlanarSurvey, U2_FusedMapsAreAsWrongAsTheyClaim) {
  double joint = 0.0;
  int dof = 0;
  int fused = 0;
  for (int seed = 0; seed < 20; ++seed) {
    Rng rng(static_cast<std::uint64_t>(200 + seed));
    const testing::LevelledWorld world = testing::survey_world(rng);
    PlanarSurvey planar(selectively_fused(), std::nullopt);
    const SurveyEstimate estimate = joined(planar, testing::survey_maps(world, {}, CompassPorts::kBorders, rng));
    const auto n = static_cast<Eigen::Index>(3 * estimate.global_T_base.size());
    ASSERT_EQ(estimate.base_covariance.rows(), n);
    Eigen::VectorXd error(n - 3);
    for (std::size_t k = 1; k < estimate.global_T_base.size(); ++k) {
      error.segment<3>(static_cast<Eigen::Index>(3 * (k - 1))) = additive_difference(estimate.global_T_base[k].mean, world.bases[k]);
    }
    joint += error.dot(estimate.base_covariance.bottomRightCorner(n - 3, n - 3).ldlt().solve(error));
    dof += static_cast<int>(n - 3);
    fused += static_cast<int>(estimate.global_T_base.size() - estimate.live_maps.size());
  }
  EXPECT_GT(fused, 40);
  EXPECT_GT(joint / dof, 0.85);
  EXPECT_LT(joint / dof, 1.25);
}

TEST(PlanarSurvey, U4_StepsGoOnAtTheBorders) {
  Rng rng(8);
  const testing::LevelledWorld world = testing::survey_world(rng);
  std::vector<LevelledSubmap> maps = testing::survey_maps(world, {}, CompassPorts::kBorders, rng);
  for (LevelledSubmap& map : maps) {  // the last step of a map is its exit: gain 1 on it, nothing left
    LevelledStep step;
    step.time_s = map.end_time_s;
    step.base_T_vehicle << map.mean(0), map.mean(1), 12.0, 0.01, -0.02, map.mean(2);
    step.gain.setZero(6, 5);
    step.gain(0, 0) = step.gain(1, 1) = step.gain(5, 2) = 1.0;
    step.covariance.setIdentity();
    map.steps.push_back(step);
  }
  PlanarSurvey planar(selectively_fused(), std::nullopt);
  const SurveyEstimate estimate = joined(planar, maps);
  ASSERT_EQ(estimate.steps.size(), maps.size());
  for (std::size_t k = 0; k + 1 < maps.size(); ++k) {
    const SurveyStep& step = estimate.steps[k];
    const GaussianSe2& next = estimate.global_T_base[k + 1];
    EXPECT_LT((step.global_T_vehicle.head<2>() - next.mean.translation()).norm(), 1e-6);
    EXPECT_NEAR(angle_difference(step.global_T_vehicle(5), next.mean.heading), 0.0, 1e-7);
    EXPECT_EQ(step.global_T_vehicle(2), 12.0);
    const std::vector<Eigen::Index> rows{0, 1, 5};
    EXPECT_LT((step.covariance(rows, rows) - next.covariance).norm(), 1e-5 * (1.0 + next.covariance.norm()));
  }
}

TEST(PlanarSurvey, U5_AWorldAlignedToNorthIsTheSameWorldTurned) {
  Rng rng(9);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const std::vector<LevelledSubmap> maps = testing::survey_maps(world, {}, CompassPorts::kBorders, rng);
  PlanarSurvey at_start(selectively_fused(), std::nullopt);
  PlanarSurvey to_north(selectively_fused(), NorthOffset{0.2, 0.05});
  const SurveyEstimate a = joined(at_start, maps);
  const SurveyEstimate b = joined(to_north, maps);
  const Se2 turn{0.0, 0.0, angle_difference(maps[0].mean(3), 0.2)};
  const double variance = maps[0].covariance(3, 3) + 0.05 * 0.05;
  const Eigen::Matrix2d R = turn.rotation();
  for (std::size_t k = 0; k < a.global_T_base.size(); ++k) {
    const Eigen::Vector2d p = turn * a.global_T_base[k].mean.translation();
    EXPECT_LT((b.global_T_base[k].mean.translation() - p).norm(), 1e-9);
    const Eigen::Vector2d lever(-p.y(), p.x());  // of the heading on the position
    const Eigen::Matrix2d expected =
        R * a.global_T_base[k].covariance.topLeftCorner<2, 2>() * R.transpose() + variance * lever * lever.transpose();
    EXPECT_LT(((b.global_T_base[k].covariance.topLeftCorner<2, 2>() - expected).norm()), 1e-9);
    EXPECT_NEAR(b.global_T_base[k].covariance(2, 2), a.global_T_base[k].covariance(2, 2) + variance, 1e-12);
    const auto at = static_cast<Eigen::Index>(3 * k);
    EXPECT_LT(((b.base_covariance.block<3, 3>(at, at) - b.global_T_base[k].covariance).norm()), 1e-9);
  }
  for (std::size_t i = 0; i < a.landmarks.size(); ++i) {
    const Eigen::Vector2d p = turn * Eigen::Vector2d(a.landmarks[i].position.head<2>());
    const Eigen::Vector2d lever(-p.y(), p.x());
    EXPECT_LT((b.landmarks[i].position.head<2>() - p).norm(), 1e-9);
    EXPECT_EQ(b.landmarks[i].position.z(), a.landmarks[i].position.z());
    const Eigen::Matrix2d expected =
        R * a.landmarks[i].covariance.topLeftCorner<2, 2>() * R.transpose() + variance * lever * lever.transpose();
    EXPECT_LT(((b.landmarks[i].covariance.topLeftCorner<2, 2>() - expected).norm()), 1e-9);
  }
}

TEST(PlanarSurvey, WhatCannotBeIsRefused) {
  Rng rng(9);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const std::vector<LevelledSubmap> without = testing::survey_maps(world, {}, CompassPorts::kNone, rng);
  PlanarSurvey to_north(in_sequence(), NorthOffset{0.0, 0.05});
  EXPECT_THROW(static_cast<void>(to_north.take(without[0])), InvalidArgument);
  PlanarSurvey in_order(in_sequence(), std::nullopt);
  EXPECT_THROW(static_cast<void>(in_order.take(without[1])), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
