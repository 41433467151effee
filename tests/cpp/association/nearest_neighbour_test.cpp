#include "ssjs/association/nearest_neighbour.hpp"

#include <gtest/gtest.h>

#include <set>

#include "pairing_problems.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using pairing_problems::independent;

TEST(NearestNeighbour, A4_TheGloballyNearestPairComesFirst) {
  // On a line, variance 1: observations at 0 and 1, predictions at 0.8 and 3.
  // Distances squared: (0,0) 0.64, (0,1) 9, (1,0) 0.04, (1,1) 4. The nearest is (1,0); it leaves (0,1).
  const Eigen::Vector4d observed(0.0, 0.0, 1.0, 0.0);
  const Eigen::Vector4d predicted(0.8, 0.0, 3.0, 0.0);
  const Hypothesis hypothesis = nearest_neighbour(independent(observed, predicted, 0.5, 0.5), 0.99);
  EXPECT_EQ(hypothesis.pairs, (std::vector<Pair>{{0, 1}, {1, 0}}));
  EXPECT_NEAR(hypothesis.joint_squared_distance, 9.04, 1e-12);
  EXPECT_NEAR(hypothesis.nearest_squared_distance[0].value(), 0.64, 1e-12);
  EXPECT_NEAR(hypothesis.nearest_squared_distance[1].value(), 0.04, 1e-12);
}

TEST(NearestNeighbour, A4_OneToOne) {
  Rng rng(31);
  for (int trial = 0; trial < 100; ++trial) {
    const PairingProblem problem = pairing_problems::random_problem(rng, 6, 4, trial % 2 == 0);
    const Hypothesis hypothesis = nearest_neighbour(problem, 0.999);
    std::set<Eigen::Index> observations;
    std::set<Eigen::Index> predictions;
    for (const Pair& pair : hypothesis.pairs) {
      EXPECT_TRUE(observations.insert(pair.observation).second);
      EXPECT_TRUE(predictions.insert(pair.prediction).second);
    }
    const double expected = pairing_problems::dense_squared_distance(problem, hypothesis.pairs);
    EXPECT_NEAR(hypothesis.joint_squared_distance, expected, 1e-9 * (1.0 + expected));
  }
}

TEST(NearestNeighbour, A4_TiesGoToTheLowerNumbers) {
  const Eigen::Vector4d observed(0.0, 0.0, 0.0, 0.0);
  const Eigen::Vector4d predicted(1.0, 0.0, -1.0, 0.0);
  const Hypothesis hypothesis = nearest_neighbour(independent(observed, predicted, 0.5, 0.5), 0.99);
  EXPECT_EQ(hypothesis.pairs, (std::vector<Pair>{{0, 0}, {1, 1}}));
}

TEST(NearestNeighbour, OnlyInsideTheGate) {
  // 99 % gate with 2 degrees of freedom: 9.210
  EXPECT_EQ(nearest_neighbour(independent(Eigen::Vector2d(3.03, 0.0), Eigen::Vector2d::Zero(), 0.5, 0.5), 0.99).pairs.size(), 1u);
  const Hypothesis outside = nearest_neighbour(independent(Eigen::Vector2d(3.04, 0.0), Eigen::Vector2d::Zero(), 0.5, 0.5), 0.99);
  EXPECT_TRUE(outside.pairs.empty());
  EXPECT_EQ(outside.joint_squared_distance, 0.0);
  EXPECT_NEAR(outside.nearest_squared_distance.front().value(), 3.04 * 3.04, 1e-12);
}

TEST(NearestNeighbour, PairsAcrossPi) {
  PairingProblem problem = independent(Eigen::Vector2d(10.0, -kPi + 0.01), Eigen::Vector2d(10.0, kPi - 0.01), 1e-3, 1e-3);
  problem.second_component_is_angle = true;
  const Hypothesis hypothesis = nearest_neighbour(problem, 0.99);
  ASSERT_EQ(hypothesis.pairs.size(), 1u);
  EXPECT_NEAR(hypothesis.joint_squared_distance, 0.02 * 0.02 / 2e-3, 1e-9);
}

TEST(NearestNeighbour, NothingToPair) {
  EXPECT_TRUE(nearest_neighbour(PairingProblem{}, 0.99).pairs.empty());
  EXPECT_THROW((void)nearest_neighbour(PairingProblem{}, 1.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
