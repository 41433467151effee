#include "ssjs/evaluation/map_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using Ids = std::vector<std::optional<std::int64_t>>;

Ids nameless(Eigen::Index n) { return Ids(static_cast<std::size_t>(n)); }

std::vector<std::int64_t> numbered(Eigen::Index n) {
  std::vector<std::int64_t> ids(static_cast<std::size_t>(n));
  std::iota(ids.begin(), ids.end(), 100);
  return ids;
}

Eigen::Matrix2Xd points(std::initializer_list<Eigen::Vector2d> list) {
  Eigen::Matrix2Xd matrix(2, static_cast<Eigen::Index>(list.size()));
  Eigen::Index column = 0;
  for (const Eigen::Vector2d& point : list) matrix.col(column++) = point;
  return matrix;
}

Eigen::Matrix2Xd random_points(Rng& rng, Eigen::Index n, double size_m) {
  Eigen::Matrix2Xd matrix(2, n);
  for (Eigen::Index i = 0; i < n; ++i) matrix.col(i) << rng.uniform(0.0, size_m), rng.uniform(0.0, size_m);
  return matrix;
}

/// Sum of the distances, a pair beyond the limit or a landmark without one counting as the limit.
double assignment_cost(const Eigen::Matrix2Xd& estimated, const Eigen::Matrix2Xd& truth,
                       const std::vector<std::optional<Eigen::Index>>& truth_of, double limit_m) {
  double cost = 0.0;
  for (std::size_t i = 0; i < truth_of.size(); ++i) {
    cost += truth_of[i] ? (estimated.col(static_cast<Eigen::Index>(i)) - truth.col(*truth_of[i])).norm() : limit_m;
  }
  return cost;
}

/// The same over every permutation: at most 7 landmarks, no more estimates than truths.
double least_cost(const Eigen::Matrix2Xd& estimated, const Eigen::Matrix2Xd& truth, double limit_m) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(truth.cols()));
  std::iota(order.begin(), order.end(), 0);
  double least = std::numeric_limits<double>::infinity();
  do {
    double cost = 0.0;
    for (Eigen::Index i = 0; i < estimated.cols(); ++i) {
      cost += std::min(limit_m, (estimated.col(i) - truth.col(order[static_cast<std::size_t>(i)])).norm());
    }
    least = std::min(least, cost);
  } while (std::next_permutation(order.begin(), order.end()));
  return least;
}

TEST(MapError, E6_TheBestTotalNotTheNearestNeighbour) {
  // on a line: taking the nearest pair first (estimate 4 with truth 5) would leave estimate 6 with truth 0
  const Eigen::Matrix2Xd truth = points({{0.0, 0.0}, {5.0, 0.0}});
  const Eigen::Matrix2Xd estimated = points({{4.0, 0.0}, {7.0, 0.0}});
  const std::optional<MapError> error = map_error(estimated, nameless(2), truth, numbered(2), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->truth_of[0], 0);
  EXPECT_EQ(error->truth_of[1], 1);
  EXPECT_NEAR(error->mean_m, 3.0, 1e-12);
}

TEST(MapError, E6_EqualsTheSearchOverAllPermutations) {
  Rng rng(101);
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Index truths = 2 + trial % 6;
    const Eigen::Index estimates = 1 + static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(truths)));
    const Eigen::Matrix2Xd truth = random_points(rng, truths, 10.0);
    const Eigen::Matrix2Xd estimated = random_points(rng, estimates, 10.0);
    const double limit_m = rng.uniform(1.0, 12.0);
    const std::optional<MapError> error = map_error(estimated, nameless(estimates), truth, numbered(truths), {limit_m, false});
    const double least = least_cost(estimated, truth, limit_m);
    if (!error) {
      EXPECT_NEAR(least, limit_m * static_cast<double>(estimates), 1e-9);
      continue;
    }
    EXPECT_NEAR(assignment_cost(estimated, truth, error->truth_of, limit_m), least, 1e-9);
  }
}

TEST(MapError, E6_MoreEstimatesThanTruthsMirrorsTheOtherWay) {
  Rng rng(102);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Matrix2Xd few = random_points(rng, 4, 10.0);
    const Eigen::Matrix2Xd many = random_points(rng, 7, 10.0);
    const std::optional<MapError> one_way = map_error(few, nameless(4), many, numbered(7), {4.0, false});
    const std::optional<MapError> other_way = map_error(many, nameless(7), few, numbered(4), {4.0, false});
    ASSERT_EQ(one_way.has_value(), other_way.has_value());
    if (!one_way) continue;
    EXPECT_EQ(one_way->matched, other_way->matched);
    EXPECT_NEAR(one_way->mean_m, other_way->mean_m, 1e-9);
    EXPECT_EQ(other_way->false_landmarks, 7 - other_way->matched);
    EXPECT_EQ(other_way->missed, 4 - other_way->matched);
  }
}

TEST(MapError, E6_NoLandmarkIsUsedTwice) {
  const Eigen::Matrix2Xd truth = points({{0.0, 0.0}});
  const Eigen::Matrix2Xd estimated = points({{0.3, 0.0}, {0.1, 0.0}, {0.2, 0.0}});
  const std::optional<MapError> error = map_error(estimated, nameless(3), truth, numbered(1), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->matched, 1);
  EXPECT_EQ(error->false_landmarks, 2);
  EXPECT_EQ(error->truth_of[1], 0);
}

TEST(MapError, E6_BeyondTheLimitAPairIsAMissedAndAFalseLandmark) {
  const Eigen::Matrix2Xd truth = points({{0.0, 0.0}, {100.0, 0.0}});
  const Eigen::Matrix2Xd estimated = points({{1.0, 0.0}, {111.0, 0.0}});
  const std::optional<MapError> error = map_error(estimated, nameless(2), truth, numbered(2), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->matched, 1);
  EXPECT_EQ(error->missed, 1);
  EXPECT_EQ(error->false_landmarks, 1);
  EXPECT_FALSE(error->truth_of[1]);
  // the same by identity
  const std::optional<MapError> named = map_error(estimated, {100, 101}, truth, numbered(2), {10.0, false});
  ASSERT_TRUE(named);
  EXPECT_EQ(named->matched, 1);
  EXPECT_FALSE(map_error(estimated.rightCols(1), nameless(1), truth, numbered(2), {10.0, false}));
}

TEST(MapError, E6_IdentitiesComeFirstAndARepeatedOneKeepsItsNearestCopy) {
  const Eigen::Matrix2Xd truth = points({{0.0, 0.0}, {5.0, 0.0}, {10.0, 0.0}});
  // swapped places, a copy, and one that the truth does not know
  const Eigen::Matrix2Xd estimated = points({{5.0, 0.0}, {0.0, 0.0}, {3.0, 0.0}, {10.5, 0.0}});
  const std::optional<MapError> error = map_error(estimated, {100, 101, 100, 7}, truth, numbered(3), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_FALSE(error->truth_of[0]);  // 5 m from truth 100; its copy is 3 m away
  EXPECT_EQ(error->truth_of[1], 1);  // 5 m
  EXPECT_EQ(error->truth_of[2], 0);  // 3 m
  EXPECT_EQ(error->truth_of[3], 2);  // unknown identity: assigned by distance, 0.5 m
  EXPECT_EQ(error->matched, 3);
  EXPECT_EQ(error->false_landmarks, 1);
  EXPECT_EQ(error->missed, 0);
}

TEST(MapError, E7_StatisticsByHand) {
  const Eigen::Matrix2Xd truth = points({{0.0, 0.0}, {50.0, 0.0}});
  const Eigen::Matrix2Xd estimated = points({{3.0, 4.0}, {50.0, 1.0}});
  const std::optional<MapError> error = map_error(estimated, nameless(2), truth, numbered(2), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->mean_m, 3.0, 1e-12);              // (5 + 1) / 2
  EXPECT_NEAR(error->std_m, 2.0, 1e-12);               // both 2 from the mean
  EXPECT_NEAR(error->rmse_m, std::sqrt(13.0), 1e-12);  // (25 + 1) / 2
  EXPECT_NEAR(error->max_m, 5.0, 1e-12);
}

TEST(MapError, AlignmentLeavesTheShapeAlone) {
  Rng rng(103);
  const Eigen::Matrix2Xd truth = random_points(rng, 30, 100.0);
  const Se2 estimate_T_truth{40.0, -20.0, 2.0};
  Eigen::Matrix2Xd estimated(2, 30);
  Ids ids;
  for (Eigen::Index i = 0; i < 30; ++i) {
    estimated.col(i) = estimate_T_truth * Eigen::Vector2d(truth.col(i));
    ids.push_back(100 + i);
  }
  const std::optional<MapError> error = map_error(estimated, ids, truth, numbered(30), {10.0, true});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->matched, 30);
  EXPECT_NEAR(error->max_m, 0.0, 1e-9);
}

TEST(MapError, AlignmentWithoutIdentitiesPairsAgainAfterTheMotion) {
  // a small rotation of a large grid: at the far corner, 134 m away, the unaligned nearest neighbour is the wrong one (3.4 m against half
  // of 5 m)
  Eigen::Matrix2Xd truth(2, 400);
  Eigen::Matrix2Xd estimated(2, 400);
  const Se2 estimate_T_truth{0.2, -0.1, 0.025};
  for (Eigen::Index i = 0; i < 400; ++i) {
    truth.col(i) << 5.0 * static_cast<double>(i % 20), 5.0 * static_cast<double>(i / 20);
    estimated.col(i) = estimate_T_truth * Eigen::Vector2d(truth.col(i));
  }
  const std::optional<MapError> error = map_error(estimated, nameless(400), truth, numbered(400), {2.0, true});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->matched, 400);
  EXPECT_NEAR(error->max_m, 0.0, 1e-9);
}

TEST(MapError, AlignmentNeedsTwoPairs) {
  const Eigen::Matrix2Xd one = points({{1.0, 1.0}});
  EXPECT_TRUE(map_error(one, nameless(1), one, numbered(1), {10.0, false}));
  EXPECT_FALSE(map_error(one, nameless(1), one, numbered(1), {10.0, true}));
}

TEST(MapError, ManyLandmarks) {
  // 20,000 landmarks 5 m apart, each with a dozen candidates inside the limit: 0.1 s; a dense solution would have 3 GB of costs
  Rng rng(104);
  const Eigen::Index n = 20000;
  Eigen::Matrix2Xd truth(2, n);
  Eigen::Matrix2Xd estimated(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    truth.col(i) << 5.0 * static_cast<double>(i % 200), 5.0 * static_cast<double>(i / 200);
    estimated.col(i) = truth.col(i) + Eigen::Vector2d(rng.normal(1.5), rng.normal(1.5));
  }
  const std::optional<MapError> error = map_error(estimated, nameless(n), truth, numbered(n), {10.0, false});
  ASSERT_TRUE(error);
  EXPECT_GE(error->matched, n - 20);
}

TEST(MapError, BrokenContractsAreNamed) {
  const Eigen::Matrix2Xd two = points({{0.0, 0.0}, {1.0, 0.0}});
  EXPECT_THROW((void)map_error(two, nameless(1), two, numbered(2), {10.0, false}), InvalidArgument);
  EXPECT_THROW((void)map_error(two, nameless(2), two, numbered(3), {10.0, false}), InvalidArgument);
  EXPECT_THROW((void)map_error(two, nameless(2), two, {5, 5}, {10.0, false}), InvalidArgument);
  EXPECT_THROW((void)map_error(two, nameless(2), two, numbered(2), {0.0, false}), InvalidArgument);
  Eigen::Matrix2Xd broken = two;
  broken(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)map_error(broken, nameless(2), two, numbered(2), {10.0, false}), InvalidArgument);
}

TEST(MapError, NothingMatchesNothing) {
  const Eigen::Matrix2Xd none(2, 0);
  const Eigen::Matrix2Xd two = points({{0.0, 0.0}, {1.0, 0.0}});
  EXPECT_FALSE(map_error(none, {}, two, numbered(2), {10.0, false}));
  EXPECT_FALSE(map_error(two, nameless(2), none, {}, {10.0, false}));
}

}  // namespace
}  // namespace ssjs
