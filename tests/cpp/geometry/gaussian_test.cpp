#include "ssjs/geometry/gaussian.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// A full covariance of the size that poses have: decimetres, degrees, correlated.
Eigen::Matrix3d random_covariance(Rng& rng) {
  Eigen::Matrix3d root;
  for (Eigen::Index i = 0; i < 9; ++i) root(i / 3, i % 3) = rng.uniform(-1.0, 1.0);
  const Eigen::Vector3d sigma(0.1, 0.2, 0.02);
  return sigma.asDiagonal() * (root * root.transpose() + 0.1 * Eigen::Matrix3d::Identity()) * sigma.asDiagonal();
}

TEST(Gaussian, S4_InverseMovesTheCovarianceByHand) {
  // a vehicle 10 m ahead on the x axis with a heading error of 0.1 rad sees the origin 10 m behind, 1 m to the side
  GaussianSe2 a{{10.0, 0.0, 0.0}, Eigen::Vector3d(0.0, 0.0, 0.01).asDiagonal()};
  Eigen::Matrix3d expected;
  expected << 0.0, 0.0, 0.0, 0.0, 1.0, -0.1, 0.0, -0.1, 0.01;
  EXPECT_NEAR((a.inverse().covariance - expected).norm(), 0.0, 1e-12);
}

TEST(Gaussian, S4_InvertingTwiceGivesTheSameGaussian) {
  Rng rng(21);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    const GaussianSe2 a{testing::random_pose(rng, point), random_covariance(rng)};
    const GaussianSe2 twice = a.inverse().inverse();
    EXPECT_NEAR(additive_difference(twice.mean, a.mean).norm(), 0.0, 1e-11);
    EXPECT_NEAR((twice.covariance - a.covariance).norm(), 0.0, 1e-11);
  }
}

TEST(Gaussian, S9_ComposingIndependentPosesByHand) {
  // heading sigma 0.1 rad at the start of a 10 m step: 1 m sideways, fully correlated with the heading
  const GaussianSe2 a{{0.0, 0.0, 0.0}, Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal()};
  const GaussianSe2 b{{10.0, 0.0, 0.0}, Eigen::Vector3d(0.25, 0.16, 0.02).asDiagonal()};
  Eigen::Matrix3d expected;
  expected << 0.04 + 0.25, 0.0, 0.0, 0.0, 0.09 + 1.0 + 0.16, 0.1, 0.0, 0.1, 0.01 + 0.02;
  EXPECT_NEAR((compose_independent(a, b).covariance - expected).norm(), 0.0, 1e-12);
}

TEST(Gaussian, S9_CovarianceMatchesSamples) {
  // additive coordinates in the parent frame: that is what the samples' scatter has to be
  Rng rng(22);
  const GaussianSe2 a{{3.0, -2.0, 3.1}, random_covariance(rng) * 1e-4};
  const GaussianSe2 b{{5.0, 4.0, 0.5}, random_covariance(rng) * 1e-4};
  const Eigen::MatrixXd L_a = cholesky_lower(a.covariance, "a", "test");
  const Eigen::MatrixXd L_b = cholesky_lower(b.covariance, "b", "test");
  const GaussianSe2 ab = compose_independent(a, b);
  const int samples = 20000;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (int i = 0; i < samples; ++i) {
    const Se2 a_i = additive_step(a.mean, L_a * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()));
    const Se2 b_i = additive_step(b.mean, L_b * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()));
    const Eigen::Vector3d error = additive_difference(a_i * b_i, ab.mean);
    scatter += error * error.transpose() / samples;
  }
  // a sample variance of n draws has a relative deviation of sqrt(2 / n) = 0.01
  EXPECT_LT((scatter - ab.covariance).norm(), 0.05 * ab.covariance.norm());
}

TEST(Gaussian, CholeskyOfAKnownMatrix) {
  Eigen::Matrix2d S;
  S << 4.0, 2.0, 2.0, 10.0;
  Eigen::Matrix2d expected;
  expected << 2.0, 0.0, 1.0, 3.0;
  EXPECT_NEAR((cholesky_lower(S, "S", "test") - expected).norm(), 0.0, 1e-15);
}

TEST(Gaussian, CholeskyRefusesIndefiniteAndNanNamingTheMatrix) {
  Eigen::Matrix2d S;
  S << 1.0, 2.0, 2.0, 1.0;
  try {
    (void)cholesky_lower(S, "innovation covariance", "landmark 17");
    FAIL() << "an indefinite matrix was factorised";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_NE(std::string(error.what()).find("innovation covariance"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("landmark 17"), std::string::npos);
  }
  S.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW((void)cholesky_lower(S, "S", "test"), NotPositiveDefinite);
}

}  // namespace
}  // namespace ssjs
