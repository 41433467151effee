#include "ssjs/association/joint_compatibility.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "pairing_problems.hpp"
#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using pairing_problems::dense_squared_distance;
using pairing_problems::independent;
using pairing_problems::random_problem;

constexpr double kRounding = 1e-9;

/// Predictions that share one unknown shift of variance 4 per axis and have 0.01 of their own; observations have 0.01.
PairingProblem shifted_together(const Eigen::VectorXd& observed, const Eigen::VectorXd& predicted) {
  PairingProblem problem = independent(observed, predicted, 0.01, 0.01);
  for (Eigen::Index j = 0; j < problem.predictions(); ++j) {
    for (Eigen::Index l = 0; l < problem.predictions(); ++l)
      problem.predicted_covariance.block<2, 2>(2 * j, 2 * l) += 4.0 * Eigen::Matrix2d::Identity();
  }
  return problem;
}

TEST(JointCompatibility, A3_JointGateRejectsMirroredPair) {
  // Landmarks at x = 0 and 30, seen at x = 1 and 29: each alone is 1 m off, distance 1 / 4.02 = 0.25, well inside the gate.
  // Together they would need a shift of +1 and of -1: the difference of the residuals is 2 with variance 4 * 0.01, so the
  // joint distance is 2^2 / 0.04 = 100 (their mean is 0), against 9.49.
  const PairingProblem problem = shifted_together(Eigen::Vector4d(1.0, 0.0, 29.0, 0.0), Eigen::Vector4d(0.0, 0.0, 30.0, 0.0));
  const Hypothesis nearest = nearest_neighbour(problem, 0.99);
  EXPECT_EQ(nearest.pairs, (std::vector<Pair>{{0, 0}, {1, 1}}));
  EXPECT_NEAR(nearest.joint_squared_distance, 100.0, kRounding);
  const Hypothesis joint = joint_compatibility(problem, {});
  EXPECT_EQ(joint.pairs, (std::vector<Pair>{{0, 0}}));
  EXPECT_NEAR(joint.joint_squared_distance, 1.0 / 4.02, kRounding);
}

TEST(JointCompatibility, A3_CommonShiftIsFollowedThoughOtherLandmarksAreNearer) {
  // Everything is 2 m to the right; landmark 1 at x = 2.2 is nearer to observation 0 than its own landmark 0 is.
  const Eigen::VectorXd predicted = (Eigen::VectorXd(6) << 0.0, 0.0, 2.2, 0.0, 20.0, 5.0).finished();
  const Eigen::VectorXd observed = (Eigen::VectorXd(6) << 2.0, 0.0, 4.2, 0.0, 22.0, 5.0).finished();
  const PairingProblem problem = shifted_together(observed, predicted);
  EXPECT_EQ(nearest_neighbour(problem, 0.99).pairs[0], (Pair{0, 1}));
  EXPECT_EQ(joint_compatibility(problem, {}).pairs, (std::vector<Pair>{{0, 0}, {1, 1}, {2, 2}}));
}

TEST(JointCompatibility, A3_EqualsEnumerationOfAllSets) {
  Rng rng(41);
  int sets = 0;
  int pairs = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Index m = 2 + trial % 4;
    const Eigen::Index n = 3 + trial % 3;
    const PairingProblem problem = random_problem(rng, m, n, trial % 2 == 0);
    JointCompatibilityConfig config;
    config.joint_gate_probability = trial % 5 == 0 ? 0.5 : 0.95;
    config.node_budget = 1000000;
    const pairing_problems::Enumeration enumeration(problem, joint_gates(config.gate_probability, 1)[0], config.joint_gate_probability);
    const Hypothesis hypothesis = joint_compatibility(problem, config);
    EXPECT_EQ(hypothesis.pairs, enumeration.best) << "trial " << trial;
    EXPECT_NEAR(hypothesis.joint_squared_distance, enumeration.best_squared_distance,
                kRounding * (1.0 + enumeration.best_squared_distance));
    EXPECT_FALSE(hypothesis.budget_exhausted);
    sets += enumeration.sets;
    pairs += static_cast<int>(hypothesis.pairs.size());
  }
  EXPECT_GT(sets, 200 * 20);  // the problems are ambiguous
  EXPECT_GT(pairs, 200);
}

TEST(JointCompatibility, A3_SetWhosePartsFailTheirOwnGateIsFound) {
  // Independent, variance 1. Observation 0 has one candidate at distance 8 (alone beyond 5.991), the others two candidates each,
  // the better at distance 0.01. All three: 8.02 <= 12.592.
  const Eigen::VectorXd predicted = (Eigen::VectorXd(10) << 0.0, 0.0, 50.0, 0.0, 50.0, 2.0, 90.0, 0.0, 90.0, 2.0).finished();
  const Eigen::VectorXd observed = (Eigen::VectorXd(6) << std::sqrt(8.0), 0.0, 50.1, 0.0, 90.1, 0.0).finished();
  const Hypothesis hypothesis = joint_compatibility(independent(observed, predicted, 0.5, 0.5), {});
  EXPECT_EQ(hypothesis.pairs, (std::vector<Pair>{{0, 0}, {1, 1}, {2, 3}}));
  EXPECT_NEAR(hypothesis.joint_squared_distance, 8.02, kRounding);
}

TEST(JointCompatibility, SingleObservationEqualsBothGates) {
  // 2 degrees of freedom: 5.991 at 95 % (joint), 9.210 at 99 % (individual)
  const auto pairs_at = [](double squared_distance, double joint_gate_probability) {
    JointCompatibilityConfig config;
    config.joint_gate_probability = joint_gate_probability;
    const PairingProblem problem = independent(Eigen::Vector2d(std::sqrt(squared_distance), 0.0), Eigen::Vector2d::Zero(), 0.5, 0.5);
    return joint_compatibility(problem, config).pairs.size();
  };
  EXPECT_EQ(pairs_at(5.98, 0.95), 1u);
  EXPECT_EQ(pairs_at(6.00, 0.95), 0u);
  EXPECT_EQ(pairs_at(9.20, 0.999), 1u);
  EXPECT_EQ(pairs_at(9.22, 0.999), 0u);
}

TEST(JointCompatibility, BudgetIsHonouredAndReported) {
  Rng rng(42);
  Eigen::VectorXd predicted(16);
  for (Eigen::Index k = 0; k < predicted.size(); ++k) predicted(k) = rng.uniform(-0.1, 0.1);
  const PairingProblem problem = independent(Eigen::VectorXd::Zero(16), predicted, 0.5, 0.5);  // every pairing is good
  for (const int budget : {1, 5, 100}) {
    JointCompatibilityConfig config;
    config.node_budget = budget;
    const Hypothesis hypothesis = joint_compatibility(problem, config);
    EXPECT_TRUE(hypothesis.budget_exhausted);
    EXPECT_EQ(hypothesis.nodes_visited, budget);
    EXPECT_EQ(hypothesis.pairs.size(), static_cast<std::size_t>(std::min(budget, 8)));  // the first dive takes one more pair per node
    EXPECT_NEAR(hypothesis.joint_squared_distance, dense_squared_distance(problem, hypothesis.pairs), kRounding);
  }
  EXPECT_THROW((void)joint_compatibility(problem, {0.99, 0.95, 0}), InvalidArgument);
}

TEST(JointCompatibility, UnambiguousScanCostsOneNodePerPair) {
  Eigen::VectorXd points(20);
  for (Eigen::Index i = 0; i < 10; ++i) points.segment<2>(2 * i) << 10.0 * static_cast<double>(i), 0.0;
  const Hypothesis hypothesis = joint_compatibility(shifted_together(points.array() + 0.5, points), {});
  EXPECT_EQ(hypothesis.pairs.size(), 10u);
  EXPECT_EQ(hypothesis.nodes_visited, 10);
  EXPECT_FALSE(hypothesis.budget_exhausted);
}

TEST(JointCompatibility, BearingsPairAcrossPi) {
  const Eigen::Vector4d predicted(10.0, kPi - 0.01, 12.0, -kPi + 0.2);
  const Eigen::Vector4d observed(10.0, -kPi + 0.01, 12.0, -kPi + 0.22);
  PairingProblem problem = independent(observed, predicted, 1e-3, 1e-3);
  problem.second_component_is_angle = true;
  const Hypothesis hypothesis = joint_compatibility(problem, {});
  EXPECT_EQ(hypothesis.pairs, (std::vector<Pair>{{0, 0}, {1, 1}}));
  EXPECT_NEAR(hypothesis.joint_squared_distance, 2.0 * 0.02 * 0.02 / 2e-3, kRounding);
}

TEST(JointCompatibility, ResultDoesNotDependOnTheOrder) {
  Rng rng(43);
  for (int trial = 0; trial < 60; ++trial) {
    const Eigen::Index m = 5;
    const Eigen::Index n = 7;
    const PairingProblem problem = random_problem(rng, m, n, true);
    const auto permutation = [&](Eigen::Index size) {
      std::vector<Eigen::Index> order(static_cast<std::size_t>(size));
      std::iota(order.begin(), order.end(), Eigen::Index{0});
      for (std::size_t k = 0; k + 1 < order.size(); ++k) std::swap(order[k], order[k + rng.below(order.size() - k)]);
      return order;
    };
    const std::vector<Eigen::Index> observation_at = permutation(m);  // new number -> old number
    const std::vector<Eigen::Index> prediction_at = permutation(n);
    const auto expand = [](const std::vector<Eigen::Index>& order) {
      std::vector<Eigen::Index> components;
      for (const Eigen::Index k : order) components.insert(components.end(), {2 * k, 2 * k + 1});
      return components;
    };
    const std::vector<Eigen::Index> o = expand(observation_at);
    const std::vector<Eigen::Index> p = expand(prediction_at);
    PairingProblem permuted;
    permuted.observed = problem.observed(o);
    permuted.predicted = problem.predicted(p);
    permuted.observed_covariance = problem.observed_covariance(o, o);
    permuted.predicted_covariance = problem.predicted_covariance(p, p);
    permuted.cross_covariance = problem.cross_covariance(p, o);

    const Hypothesis expected = joint_compatibility(problem, {});
    Hypothesis hypothesis = joint_compatibility(permuted, {});
    ASSERT_FALSE(expected.budget_exhausted);
    for (Pair& pair : hypothesis.pairs) {
      pair = {observation_at[static_cast<std::size_t>(pair.observation)], prediction_at[static_cast<std::size_t>(pair.prediction)]};
    }
    std::sort(hypothesis.pairs.begin(), hypothesis.pairs.end());
    EXPECT_EQ(hypothesis.pairs, expected.pairs);
    EXPECT_NEAR(hypothesis.joint_squared_distance, expected.joint_squared_distance, kRounding * (1.0 + expected.joint_squared_distance));
  }
}

TEST(JointCompatibility, SubsetOfTheObservationsEqualsTheSmallerProblem) {
  Rng rng(44);
  const PairingProblem problem = random_problem(rng, 5, 6, false);
  const JointCompatibilityConfig config;
  const Compatibility compatibility = individual_compatibility(problem, joint_gates(config.gate_probability, 1)[0]);
  const Hypothesis subset = joint_compatibility(problem, compatibility, {0, 1, 2}, config);
  PairingProblem smaller = problem;
  smaller.observed = problem.observed.head(6);
  smaller.observed_covariance = problem.observed_covariance.topLeftCorner(6, 6);
  const Hypothesis expected = joint_compatibility(smaller, config);
  EXPECT_EQ(subset.pairs, expected.pairs);
  EXPECT_EQ(subset.joint_squared_distance, expected.joint_squared_distance);
}

TEST(JointCompatibility, NearestDistancesServeTheDeadBand) {
  // variance 1; observation 1 is 6 away from its nearest prediction: distance 36, beyond every gate but known
  const Hypothesis hypothesis =
      joint_compatibility(independent(Eigen::Vector4d(0.1, 0.0, 6.0, 0.0), Eigen::Vector2d::Zero(), 0.5, 0.5), {});
  EXPECT_EQ(hypothesis.pairs, (std::vector<Pair>{{0, 0}}));
  EXPECT_NEAR(hypothesis.nearest_squared_distance[1].value(), 36.0, kRounding);
}

TEST(JointCompatibility, NothingToPair) {
  const Hypothesis empty = joint_compatibility(PairingProblem{}, {});
  EXPECT_TRUE(empty.pairs.empty());
  EXPECT_EQ(empty.nodes_visited, 0);
  const Hypothesis unmatched = joint_compatibility(independent(Eigen::Vector2d::Zero(), Eigen::VectorXd(0), 1.0, 1.0), {});
  EXPECT_EQ(unmatched.nearest_squared_distance.size(), 1u);
  EXPECT_FALSE(unmatched.nearest_squared_distance.front().has_value());
}

TEST(JointCompatibility, RefusesWhatIsNoCovariance) {
  EXPECT_THROW((void)joint_compatibility(independent(Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0.0, 0.0), {}), NotPositiveDefinite);
  // Each residual alone is fine, both together are one random number.
  PairingProblem problem = independent(Eigen::Vector4d(0.0, 0.0, 9.0, 0.0), Eigen::Vector4d(0.0, 0.0, 9.0, 0.0), 1.0, 0.0);
  problem.observed_covariance.topRightCorner<2, 2>().setIdentity();
  problem.observed_covariance.bottomLeftCorner<2, 2>().setIdentity();
  EXPECT_THROW((void)joint_compatibility(problem, {}), NotPositiveDefinite);
}

}  // namespace
}  // namespace ssjs
