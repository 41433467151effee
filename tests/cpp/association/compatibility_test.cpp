#include "ssjs/association/compatibility.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "pairing_problems.hpp"
#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using pairing_problems::independent;
using pairing_problems::random_problem;

constexpr double kRounding = 1e-12;

TEST(Compatibility, A1_CovarianceOfTwoResidualsFromTheJointCovariance) {
  Rng rng(11);
  const Eigen::Index m = 3;
  const Eigen::Index n = 4;
  const PairingProblem problem = random_problem(rng, m, n, true);
  // P_all of the stacked (predicted, observed); a residual is D (predicted, observed) with D = [-I at j | +I at i].
  Eigen::MatrixXd P_all(2 * (n + m), 2 * (n + m));
  P_all << problem.predicted_covariance, problem.cross_covariance, problem.cross_covariance.transpose(), problem.observed_covariance;
  const auto selector = [&](const Pair& pair) {
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(2, 2 * (n + m));
    D.middleCols<2>(2 * pair.prediction) = -Eigen::Matrix2d::Identity();
    D.middleCols<2>(2 * n + 2 * pair.observation) = Eigen::Matrix2d::Identity();
    return D;
  };
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Pair ij{i, j};
      const Pair kl{(i + 1) % m, (2 * j + 1) % n};
      const Eigen::Matrix2d expected = selector(ij) * P_all * selector(kl).transpose();
      EXPECT_LE((pair_covariance(problem, ij, kl) - expected).norm(), kRounding);
    }
  }
}

TEST(Compatibility, A2_DistanceByHand) {
  // residual (1, 2), covariance [[2, 1], [1, 3]]: inverse 1/5 [[3, -1], [-1, 2]], distance (3 - 2*2 + 2*4)/5 = 7/5
  PairingProblem problem = independent(Eigen::Vector2d(1.0, 2.0), Eigen::Vector2d(0.0, 0.0), 1.0, 1.0);
  problem.observed_covariance << 1.0, 1.0, 1.0, 2.0;
  const Compatibility compatibility = individual_compatibility(problem, 9.21);
  EXPECT_NEAR(compatibility.squared_distance(0, 0), 7.0 / 5.0, kRounding);
}

TEST(Compatibility, CandidatesNearestFirstAndTiesByNumber) {
  // variance 1 in all, so distances are squared lengths: 4, 1, 1, 16
  const Eigen::VectorXd predicted = (Eigen::VectorXd(8) << 2.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 4.0).finished();
  const Compatibility compatibility = individual_compatibility(independent(Eigen::Vector2d::Zero(), predicted, 0.5, 0.5), 9.0);
  EXPECT_EQ(compatibility.candidates.front(), (std::vector<Eigen::Index>{1, 2, 0}));
}

TEST(Compatibility, NearestDistanceIsKnownBeyondTheGate) {
  const Eigen::VectorXd predicted = (Eigen::VectorXd(6) << 100.0, 0.0, 0.0, 6.0, 0.0, -70.0).finished();
  const Compatibility compatibility = individual_compatibility(independent(Eigen::Vector2d::Zero(), predicted, 0.5, 0.5), 9.0);
  EXPECT_TRUE(compatibility.candidates.front().empty());
  EXPECT_NEAR(nearest_squared_distances(compatibility).front().value(), 36.0, kRounding);
}

TEST(Compatibility, WithoutPredictionsNothingIsNearest) {
  const PairingProblem problem = independent(Eigen::Vector2d::Zero(), Eigen::VectorXd(0), 1.0, 1.0);
  const Compatibility compatibility = individual_compatibility(problem, 9.0);
  EXPECT_EQ(compatibility.candidates.size(), 1u);
  EXPECT_FALSE(nearest_squared_distances(compatibility).front().has_value());
}

TEST(Compatibility, AnglesAreComparedAcrossPi) {
  PairingProblem problem = independent(Eigen::Vector2d(10.0, -kPi + 0.01), Eigen::Vector2d(10.0, kPi - 0.02), 0.5, 0.5);
  problem.second_component_is_angle = true;
  EXPECT_NEAR(pair_residual(problem, 0, 0).y(), 0.03, kRounding);
  EXPECT_NEAR(individual_compatibility(problem, 9.0).squared_distance(0, 0), 0.0009, kRounding);
  problem.second_component_is_angle = false;
  EXPECT_NEAR(pair_residual(problem, 0, 0).y(), 0.03 - 2.0 * kPi, kRounding);
}

TEST(Compatibility, AgreesWithADenseInverseWhereEvaluated) {
  Rng rng(12);
  for (int trial = 0; trial < 50; ++trial) {
    const PairingProblem problem = random_problem(rng, 4, 6, trial % 2 == 0);
    const double gate = 9.21;
    const Compatibility compatibility = individual_compatibility(problem, gate);
    for (Eigen::Index i = 0; i < 4; ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      std::size_t inside = 0;
      for (Eigen::Index j = 0; j < 6; ++j) {
        const double expected = pairing_problems::dense_squared_distance(problem, {{i, j}});
        nearest = std::min(nearest, expected);
        inside += expected <= gate;
        const double distance = compatibility.squared_distance(i, j);
        if (std::isfinite(distance)) {
          EXPECT_NEAR(distance, expected, 1e-9 * (1.0 + expected));
        } else {
          EXPECT_GT(expected, gate);
        }
      }
      EXPECT_EQ(compatibility.candidates[static_cast<std::size_t>(i)].size(), inside);
      EXPECT_NEAR(compatibility.squared_distance.row(i).minCoeff(), nearest, 1e-9 * (1.0 + nearest));
    }
  }
}

TEST(Compatibility, RefusesWhatIsNoCovariance) {
  PairingProblem problem = independent(Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0.0, 0.0);
  try {
    (void)individual_compatibility(problem, 9.0);
    FAIL() << "a zero covariance was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_NE(std::string(error.what()).find("observation 0 with prediction 0"), std::string::npos) << error.what();
  }
  problem.observed_covariance << 1.0, 2.0, 2.0, 1.0;  // determinant -3
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), NotPositiveDefinite);
  problem.observed_covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), NotPositiveDefinite);
}

TEST(Compatibility, RefusesShapesAndValuesThatDoNotFit) {
  const PairingProblem good = independent(Eigen::Vector4d::Zero(), Eigen::Vector2d::Zero(), 1.0, 1.0);
  EXPECT_NO_THROW((void)individual_compatibility(good, 9.0));
  PairingProblem problem = good;
  problem.cross_covariance = Eigen::MatrixXd::Zero(4, 2);  // is 2n x 2m = 2 x 4
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), InvalidArgument);
  problem = good;
  problem.observed_covariance = Eigen::MatrixXd::Identity(2, 2);
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), InvalidArgument);
  problem = good;
  problem.predicted = Eigen::VectorXd::Zero(3);
  problem.predicted_covariance = Eigen::MatrixXd::Identity(3, 3);
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), InvalidArgument);
  problem = good;
  problem.observed(2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)individual_compatibility(problem, 9.0), InvalidArgument);
  EXPECT_THROW((void)individual_compatibility(good, 0.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
