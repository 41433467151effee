#include "ssjs/geometry/point_alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

const Eigen::VectorXd kNoWeights;

Eigen::Matrix2Xd moved(const Se2& a_T_b, const Eigen::Matrix2Xd& b_points) {
  Eigen::Matrix2Xd a_points(2, b_points.cols());
  for (Eigen::Index i = 0; i < b_points.cols(); ++i) a_points.col(i) = a_T_b * Eigen::Vector2d(b_points.col(i));
  return a_points;
}

Eigen::Matrix2Xd random_points(Rng& rng, Eigen::Index n) {
  Eigen::Matrix2Xd points(2, n);
  for (Eigen::Index i = 0; i < n; ++i) points.col(i) << rng.uniform(-20.0, 20.0), rng.uniform(-20.0, 20.0);
  return points;
}

double cost(const Se2& a_T_b, const Eigen::Matrix2Xd& a, const Eigen::Matrix2Xd& b, const Eigen::VectorXd& weights) {
  return (a - moved(a_T_b, b)).colwise().squaredNorm().dot(weights);
}

TEST(PointAlignment, S10_RecoversAnExactMotion) {
  Rng rng(31);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    const Se2 truth = testing::random_pose(rng, point);
    const Eigen::Matrix2Xd b = random_points(rng, 2 + point % 5);
    const std::optional<Se2> found = align_points(moved(truth, b), b, kNoWeights);
    ASSERT_TRUE(found);
    EXPECT_NEAR(additive_difference(*found, truth).norm(), 0.0, 1e-10);
  }
}

TEST(PointAlignment, S10_NoSmallMotionDoesBetter) {
  Rng rng(32);
  const Eigen::Matrix2Xd b = random_points(rng, 7);
  const Eigen::Matrix2Xd a = moved({1.0, 2.0, 3.0}, b) + 0.05 * random_points(rng, 7);
  Eigen::VectorXd weights(7);
  weights << 1.0, 2.0, 0.5, 3.0, 1.0, 0.0, 4.0;
  const std::optional<Se2> found = align_points(a, b, weights);
  ASSERT_TRUE(found);
  const double least = cost(*found, a, b, weights);
  for (int coordinate = 0; coordinate < 3; ++coordinate) {
    for (const double step : {-1e-3, 1e-3}) {
      EXPECT_GT(cost(additive_step(*found, step * Eigen::Vector3d::Unit(coordinate)), a, b, weights), least);
    }
  }
}

TEST(PointAlignment, S10_WeightTwoEqualsAPairGivenTwice) {
  Rng rng(33);
  const Eigen::Matrix2Xd b = random_points(rng, 4);
  const Eigen::Matrix2Xd a = moved({1.0, 2.0, -2.0}, b) + 0.1 * random_points(rng, 4);
  Eigen::Matrix2Xd a_twice(2, 5);
  Eigen::Matrix2Xd b_twice(2, 5);
  a_twice << a, a.col(3);
  b_twice << b, b.col(3);
  const std::optional<Se2> weighted = align_points(a, b, Eigen::Vector4d(1.0, 1.0, 1.0, 2.0));
  const std::optional<Se2> repeated = align_points(a_twice, b_twice, kNoWeights);
  ASSERT_TRUE(weighted && repeated);
  EXPECT_NEAR(additive_difference(*weighted, *repeated).norm(), 0.0, 1e-12);
}

TEST(PointAlignment, S10_CollinearPointsAlign) {
  Eigen::Matrix2Xd b(2, 4);
  b << 0.0, 1.0, 2.0, 5.0, 0.0, 0.0, 0.0, 0.0;
  const Se2 truth{-3.0, 7.0, 2.5};
  const std::optional<Se2> found = align_points(moved(truth, b), b, kNoWeights);
  ASSERT_TRUE(found);
  EXPECT_NEAR(additive_difference(*found, truth).norm(), 0.0, 1e-12);
}

TEST(PointAlignment, FarFromTheOriginTheMotionIsStillFound) {
  Rng rng(34);
  const Eigen::Matrix2Xd b = random_points(rng, 6).colwise() + Eigen::Vector2d(500000.0, 4000000.0);
  const std::optional<Se2> found = align_points(b, b, kNoWeights);
  ASSERT_TRUE(found);
  EXPECT_NEAR((moved(*found, b) - b).cwiseAbs().maxCoeff(), 0.0, 1e-6);
}

TEST(PointAlignment, EmptyWhereTheRotationIsUnobservable) {
  Eigen::Matrix2Xd one(2, 1);
  one << 1.0, 2.0;
  EXPECT_FALSE(align_points(one, one, kNoWeights));
  Eigen::Matrix2Xd apart(2, 3);
  apart << 0.0, 1.0, 2.0, 0.0, 1.0, 5.0;
  const Eigen::Matrix2Xd together = Eigen::Vector2d(1e6 + 0.1, -0.3).replicate(1, 3);
  EXPECT_FALSE(align_points(together, apart, kNoWeights));
  EXPECT_FALSE(align_points(apart, together, kNoWeights));
  EXPECT_FALSE(align_points(apart, apart, Eigen::Vector3d(0.0, 1.0, 0.0)));
  // a square against its mirror image: every rotation costs the same
  Eigen::Matrix2Xd square(2, 4);
  square << 1.0, -1.0, -1.0, 1.0, 1.0, 1.0, -1.0, -1.0;
  Eigen::Matrix2Xd mirrored = square;
  mirrored.row(1) = -square.row(1);
  EXPECT_FALSE(align_points(square, mirrored, kNoWeights));
}

TEST(PointAlignment, BrokenContractsAreNamed) {
  Eigen::Matrix2Xd points = Eigen::Matrix2Xd::Random(2, 3);
  EXPECT_THROW((void)align_points(points, points.leftCols(2), kNoWeights), InvalidArgument);
  EXPECT_THROW((void)align_points(points, points, Eigen::Vector2d(1.0, 1.0)), InvalidArgument);
  EXPECT_THROW((void)align_points(points, points, Eigen::Vector3d(1.0, -1.0, 1.0)), InvalidArgument);
  Eigen::Matrix2Xd broken = points;
  broken(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)align_points(broken, points, kNoWeights), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
