#include "ssjs/association/joint_factor.hpp"

#include <gtest/gtest.h>

#include <string>

#include "pairing_problems.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using pairing_problems::dense_squared_distance;
using pairing_problems::random_problem;

constexpr double kRounding = 1e-9;  // relative; the covariances have condition numbers of about 100

ConditionedPair append(JointFactor& factor, const Pair& pair) {
  Eigen::Matrix2Xd row(2, 2 * factor.capacity());
  ConditionedPair candidate = factor.start(pair);
  for (Eigen::Index level = 0; level < factor.size(); ++level) factor.condition(candidate, row, level);
  factor.push(candidate, row);
  return candidate;
}

TEST(JointFactor, A3_GrowsLikeTheDenseDistance) {
  Rng rng(21);
  for (int trial = 0; trial < 50; ++trial) {
    const PairingProblem problem = random_problem(rng, 5, 6, trial % 2 == 0);
    JointFactor factor(problem, 5);
    std::vector<Pair> pairs;
    for (Eigen::Index i = 0; i < 5; ++i) {
      pairs.push_back({i, (i + trial) % 6});
      const double before = factor.squared_distance();
      const ConditionedPair candidate = append(factor, pairs.back());
      const double expected = dense_squared_distance(problem, pairs);
      EXPECT_NEAR(factor.squared_distance(), expected, kRounding * (1.0 + expected));
      EXPECT_NEAR(before + candidate.squared_distance, expected, kRounding * (1.0 + expected));
    }
    EXPECT_NEAR(joint_squared_distance(problem, pairs), factor.squared_distance(), kRounding * (1.0 + factor.squared_distance()));
  }
}

TEST(JointFactor, A3_ConditionedPairIsTheGaussianConditional) {
  // Two residuals with covariance [[A, B'], [B, D]]: the second given the first has mean r2 - B A^-1 r1 and covariance D - B A^-1 B'.
  Rng rng(22);
  const PairingProblem problem = random_problem(rng, 2, 2, true);
  const Pair first{0, 1};
  const Pair second{1, 0};
  JointFactor factor(problem, 2);
  append(factor, first);
  Eigen::Matrix2Xd row(2, 4);
  ConditionedPair candidate = factor.start(second);
  factor.condition(candidate, row, 0);
  const Eigen::Matrix2d gain = pair_covariance(problem, second, first) * pair_covariance(problem, first, first).inverse();
  const Eigen::Vector2d residual = pair_residual(problem, 1, 0) - gain * pair_residual(problem, 0, 1);
  const Eigen::Matrix2d covariance = pair_covariance(problem, second, second) - gain * pair_covariance(problem, first, second);
  EXPECT_LE((candidate.residual - residual).norm(), kRounding);
  EXPECT_LE((candidate.covariance - covariance).norm(), kRounding);
}

TEST(JointFactor, A3_PopForgetsTheLastPairOnly) {
  Rng rng(23);
  const PairingProblem problem = random_problem(rng, 4, 4, false);
  JointFactor factor(problem, 4);
  append(factor, {0, 0});
  append(factor, {1, 1});
  const double two = factor.squared_distance();
  append(factor, {2, 2});
  append(factor, {3, 3});
  factor.pop();
  factor.pop();
  EXPECT_EQ(factor.squared_distance(), two);
  append(factor, {3, 2});
  const double expected = dense_squared_distance(problem, {{0, 0}, {1, 1}, {3, 2}});
  EXPECT_NEAR(factor.squared_distance(), expected, kRounding * (1.0 + expected));
  while (factor.size() > 0) factor.pop();
  EXPECT_EQ(factor.squared_distance(), 0.0);
}

TEST(JointFactor, RefusesPairsThatAreTogetherSingular) {
  // The two observations are one and the same random number, so their residuals to perfectly known points are too.
  PairingProblem problem = pairing_problems::independent(Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(), 1.0, 0.0);
  problem.observed_covariance.topRightCorner<2, 2>().setIdentity();
  problem.observed_covariance.bottomLeftCorner<2, 2>().setIdentity();
  EXPECT_EQ(joint_squared_distance(problem, {{1, 1}}), 0.0);
  try {
    (void)joint_squared_distance(problem, {{0, 0}, {1, 1}});
    FAIL() << "a singular joint covariance was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_NE(std::string(error.what()).find("observation 1 with prediction 1"), std::string::npos) << error.what();
  }
}

TEST(JointFactor, A6_GatesFromTheTables) {
  // chi-squared tables, 3 decimals: 95 % with 2, 4, 6, 10, 20, 100 and 99 % with 2, 30 degrees of freedom
  const std::vector<double> gates95 = joint_gates(0.95, 50);
  const std::vector<double> gates99 = joint_gates(0.99, 15);
  constexpr double kTable = 6e-4;
  EXPECT_NEAR(gates95[0], 5.991, kTable);
  EXPECT_NEAR(gates95[1], 9.488, kTable);
  EXPECT_NEAR(gates95[2], 12.592, kTable);
  EXPECT_NEAR(gates95[4], 18.307, kTable);
  EXPECT_NEAR(gates95[9], 31.410, kTable);
  EXPECT_NEAR(gates95[49], 124.342, kTable);
  EXPECT_NEAR(gates99[0], 9.210, kTable);
  EXPECT_NEAR(gates99[14], 50.892, kTable);
}

TEST(JointFactor, A6_GatesEqualTheGeneralQuantile) {
  for (const double probability : {0.05, 0.5, 0.9, 0.99, 0.999999}) {
    const std::vector<double> gates = joint_gates(probability, 200);
    for (std::size_t k = 1; k <= gates.size(); ++k) {
      const double expected = chi_squared_quantile(probability, 2.0 * static_cast<double>(k));
      EXPECT_NEAR(gates[k - 1], expected, 1e-9 * expected) << "probability " << probability << ", pairs " << k;
    }
  }
}

TEST(JointFactor, GatesNeedAProbability) {
  EXPECT_TRUE(joint_gates(0.95, 0).empty());
  for (const double probability : {0.0, 1.0, -0.1, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW((void)joint_gates(probability, 3), InvalidArgument);
  }
}

}  // namespace
}  // namespace ssjs
