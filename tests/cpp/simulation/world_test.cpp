#include "ssjs/simulation/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(World, GridSurveyIsTheStatedFieldAndPath) {
  const World world = grid_survey_world();
  ASSERT_EQ(world.landmarks_m.cols(), 441);
  EXPECT_EQ(world.ids.size(), 441u);
  EXPECT_EQ(world.landmarks_m.rowwise().minCoeff(), Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(world.landmarks_m.rowwise().maxCoeff(), Eigen::Vector2d(100.0, 100.0));
  EXPECT_EQ((world.landmarks_m.col(22) - world.landmarks_m.col(0)), Eigen::Vector2d(5.0, 5.0));
  ASSERT_EQ(world.waypoints.size(), 40u);
  EXPECT_EQ(world.waypoints[0], Eigen::Vector2d(5.0, 2.5));
  EXPECT_EQ(world.waypoints[1], Eigen::Vector2d(95.0, 2.5));
  EXPECT_EQ(world.waypoints[2], Eigen::Vector2d(95.0, 12.5));
  EXPECT_EQ(world.waypoints[19], Eigen::Vector2d(5.0, 92.5));
  EXPECT_EQ(world.waypoints[20], Eigen::Vector2d(5.0, 97.5));
  EXPECT_EQ(world.waypoints[22], Eigen::Vector2d(95.0, 87.5));
  EXPECT_EQ(world.waypoints[39], Eigen::Vector2d(5.0, 7.5));
  // 20 lines of 90 m, twice 9 steps of 10 m, and 5 m from the way up to the way down
  EXPECT_NEAR(path_length_m(world), 20.0 * 90.0 + 18.0 * 10.0 + 5.0, 1e-9);
}

TEST(World, GridFieldIsTheFieldOfTheSurvey) {
  const World survey = grid_survey_world();
  const World field = grid_field(21, 21, 5.0, 0.0, 9);
  EXPECT_EQ(field.landmarks_m, survey.landmarks_m);
  EXPECT_EQ(field.ids, survey.ids);
  EXPECT_TRUE(field.waypoints.empty());
  EXPECT_EQ(grid_field(1, 1, 5.0, 0.0, 9).landmarks_m, Eigen::Matrix2Xd::Zero(2, 1));
  EXPECT_THROW((void)grid_field(0, 4, 5.0, 0.0, 9), InvalidArgument);
  EXPECT_THROW((void)grid_field(4, 4, 5.0, 2.5, 9), InvalidArgument);
}

TEST(World, RandomFieldFillsItsBoundsAndKeepsItsDistance) {
  const World field = random_field(400, 80.0, 40.0, 1.5, 3);
  ASSERT_EQ(field.landmarks_m.cols(), 400);
  EXPECT_GE(field.landmarks_m.minCoeff(), 0.0);
  EXPECT_LE(field.landmarks_m.row(0).maxCoeff(), 80.0);
  EXPECT_LE(field.landmarks_m.row(1).maxCoeff(), 40.0);
  double nearest_m = 80.0;
  for (Eigen::Index i = 0; i < 400; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) nearest_m = std::min(nearest_m, (field.landmarks_m.col(i) - field.landmarks_m.col(j)).norm());
  }
  EXPECT_GE(nearest_m, 1.5);
  // without a distance the mean is that of a uniform draw: (40, 20) m, deviation of the mean 80 / sqrt(12 * 400) = 1.2 m in x
  const World loose = random_field(400, 80.0, 40.0, 0.0, 3);
  EXPECT_NEAR(loose.landmarks_m.row(0).mean(), 40.0, 4.0 * 1.2);
  EXPECT_NEAR(loose.landmarks_m.row(1).mean(), 20.0, 4.0 * 0.6);
  EXPECT_EQ(field.landmarks_m, random_field(400, 80.0, 40.0, 1.5, 3).landmarks_m);
  EXPECT_NE(field.landmarks_m, random_field(400, 80.0, 40.0, 1.5, 4).landmarks_m);
}

TEST(World, RandomFieldWithoutRoomIsRefused) {
  // discs of 2 m radius: at most 0.91 * 100 / (pi 2^2) = 7 of them, and the margin outside, in 10 x 10 m
  EXPECT_THROW((void)random_field(100, 10.0, 10.0, 4.0, 1), InvalidArgument);
  EXPECT_THROW((void)random_field(0, 10.0, 10.0, 1.0, 1), InvalidArgument);
  EXPECT_THROW((void)random_field(5, -1.0, 10.0, 1.0, 1), InvalidArgument);
  EXPECT_THROW((void)random_field(5, 10.0, 10.0, -1.0, 1), InvalidArgument);
}

TEST(World, ExplorationCoversTheFieldOnce) {
  const World world = exploration_world(30, 21, 5.0, 0.0, 10.0, 1);
  EXPECT_EQ(world.landmarks_m.cols(), 630);
  EXPECT_EQ(world.landmarks_m.rowwise().maxCoeff(), Eigen::Vector2d(145.0, 100.0));
  // lines at 2.5, 12.5, ..., 92.5 m, 140 m long
  ASSERT_EQ(world.waypoints.size(), 20u);
  EXPECT_NEAR(path_length_m(world), 10.0 * 140.0 + 9.0 * 10.0, 1e-9);
  std::vector<double> heights;
  for (std::size_t i = 0; i < world.waypoints.size(); i += 2) heights.push_back(world.waypoints[i].y());
  EXPECT_TRUE(std::adjacent_find(heights.begin(), heights.end(), [](double a, double b) { return b - a != 10.0; }) == heights.end());
}

TEST(World, JitterStaysInItsBoundsAndFollowsTheSeed) {
  const World plain = exploration_world(200, 100, 5.0, 0.0, 10.0, 3);
  const World jittered = exploration_world(200, 100, 5.0, 1.0, 10.0, 3);
  ASSERT_EQ(jittered.landmarks_m.cols(), 20000);
  const Eigen::Matrix2Xd offset = jittered.landmarks_m - plain.landmarks_m;
  EXPECT_LE(offset.cwiseAbs().maxCoeff(), 1.0);
  EXPECT_NEAR(offset.row(0).mean(), 0.0, 0.02);  // uniform on +-1: deviation of the mean 0.004
  EXPECT_NEAR(offset.row(1).squaredNorm() / 20000.0, 1.0 / 3.0, 0.01);
  EXPECT_EQ(jittered.landmarks_m, exploration_world(200, 100, 5.0, 1.0, 10.0, 3).landmarks_m);
  EXPECT_NE(jittered.landmarks_m, exploration_world(200, 100, 5.0, 1.0, 10.0, 4).landmarks_m);
}

TEST(World, RevisitDrivesTheSameClosedCircuit) {
  // 8 columns, 5 m apart: lanes at 2.5, 12.5, 22.5, 32.5 m; lower edge 2.5, turns at 12.5 and 5 * 8.5 = 42.5 m
  const World one = revisit_world(8, 10, 5.0, 0.5, 1, 1);
  ASSERT_EQ(one.waypoints.size(), 9u);
  EXPECT_EQ(one.waypoints.front(), one.waypoints.back());
  EXPECT_EQ(one.waypoints.front(), Eigen::Vector2d(2.5, 2.5));
  EXPECT_EQ(one.waypoints[7], Eigen::Vector2d(32.5, 2.5));
  // two lanes of 40 m, two of 30 m, three steps of 10 m, 30 m back
  const double lap_m = 2.0 * 40.0 + 2.0 * 30.0 + 3.0 * 10.0 + 30.0;
  EXPECT_NEAR(path_length_m(one), lap_m, 1e-9);
  const World three = revisit_world(8, 10, 5.0, 0.5, 3, 1);
  EXPECT_EQ(three.landmarks_m, one.landmarks_m);
  EXPECT_NEAR(path_length_m(three), 3.0 * lap_m, 1e-9);
}

TEST(World, BrokenContractsAreNamed) {
  EXPECT_THROW((void)exploration_world(2, 10, 5.0, 0.0, 10.0, 1), InvalidArgument);
  EXPECT_THROW((void)exploration_world(10, 10, 5.0, 2.5, 10.0, 1), InvalidArgument);
  EXPECT_THROW((void)exploration_world(10, 10, 5.0, 0.0, 0.0, 1), InvalidArgument);
  EXPECT_THROW((void)revisit_world(3, 10, 5.0, 0.0, 1, 1), InvalidArgument);
  EXPECT_THROW((void)revisit_world(8, 10, 5.0, 0.0, 0, 1), InvalidArgument);
  EXPECT_THROW((void)revisit_world(8, 10, -5.0, 0.0, 1, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
