#include "ssjs/joining/unsound_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "joining/levelled_world.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {
namespace {

std::vector<LevelledSubmap> maps_of(testing::LevelledWorld& world) {
  Rng rng(33);
  world = testing::survey_world(rng);
  return testing::survey_maps(world, {}, CompassPorts::kBorders, rng);
}

TEST(UnsoundMap, IsOneThatIsNotFiniteOrKnowsMoreThanEverything) {
  testing::LevelledWorld world;
  const LevelledSubmap sound = maps_of(world).front();
  EXPECT_TRUE(is_sound(sound));
  LevelledSubmap broken = sound;
  broken.mean(1) = std::nan("");
  EXPECT_FALSE(is_sound(broken));
  broken = sound;
  broken.covariance(4, 4) = HUGE_VAL;
  EXPECT_FALSE(is_sound(broken));
  broken = sound;
  broken.covariance(2, 2) *= -1.0;
  EXPECT_FALSE(is_sound(broken));
  broken = sound;
  broken.covariance(1, 0) = broken.covariance(0, 1) = 2.0 * std::sqrt(broken.covariance(0, 0) * broken.covariance(1, 1));
  EXPECT_FALSE(is_sound(broken));
}

TEST(UnsoundMap, P40_WhatIsLeftIsAMapThatKnowsNothing) {
  testing::LevelledWorld world;
  LevelledSubmap broken = maps_of(world).front();
  broken.start_time_s = 100.0;
  broken.end_time_s = 150.0;
  LevelledStep step;
  step.time_s = 120.0;
  step.base_T_vehicle(0) = std::nan("");
  broken.steps = {step};
  const LevelledSubmap blank = without_knowledge(broken);
  EXPECT_TRUE(is_sound(blank));
  EXPECT_EQ(blank.index, broken.index);
  EXPECT_EQ(blank.compass, broken.compass);
  EXPECT_EQ(blank.landmark_count(), 0);
  EXPECT_EQ(blank.mean, broken.mean.head(5));
  EXPECT_NEAR(std::sqrt(blank.covariance(0, 0)), 150.0, 1e-9);  // 3 m/s for 50 s
  ASSERT_EQ(blank.steps.size(), 1U);
  EXPECT_TRUE(blank.steps[0].base_T_vehicle.allFinite());
  broken.mean.setConstant(std::nan(""));
  EXPECT_TRUE(without_knowledge(broken).mean.isZero());
}

/// One map in the middle is lost. What comes after it is tied by the landmarks that were seen before, and as sure of itself as it may be.
TEST(UnsoundMap, P40_TheSurveyGoesOnBehindIt) {
  for (const PortSolver solver : {PortSolver::kRecursive, PortSolver::kBatch}) {
    testing::LevelledWorld world;
    std::vector<LevelledSubmap> maps = maps_of(world);
    PortJoinerConfig config;
    config.solver = solver;
    config.association = AssociationMethod::kKnown;
    PortJoiner joiner(config);
    int unsound = 0;
    const std::size_t lost = maps.size() / 3;
    for (std::size_t k = 0; k < maps.size(); ++k) {
      if (k == lost) maps[k].covariance *= -1.0;
      unsound += joiner.take(maps[k]).unsound;
    }
    joiner.finish();
    EXPECT_EQ(unsound, 1);
    const testing::BaseErrors errors = testing::base_errors(joiner.level(), world.bases);
    EXPECT_LT(errors.joint_per_dof, 1.3);
    EXPECT_LT(errors.rmse_m, 2.0);
  }
}

}  // namespace
}  // namespace ssjs
