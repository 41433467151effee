#include "ssjs/joining/fusion.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/evaluation/consistency.hpp"

namespace ssjs {
namespace {

using testing::BatchSolution;
using testing::covariance_difference;
using testing::difference_in_sigmas;
using testing::noisy_submap;
using testing::pairs_by_identity;
using testing::solve_batch;
using testing::World;

/// m, and a tenth of it in radians: small enough for three steps, large against the variance of 1e-12 that keeps constraints invertible
/// (a four millionth of the heading's).
constexpr double kSmallNoise = 0.02;
/// Of a standard deviation.
constexpr double kLinearTolerance = 1e-6;

/// Bases on a bent path and landmarks all around.
World bent_world(Rng& rng, int bases, int landmarks) {
  World world{{Se2{}}, Eigen::Matrix2Xd(2, landmarks)};
  for (int k = 1; k < bases; ++k) world.global_T_base.push_back(world.global_T_base.back() * Se2{6.0, 0.5, 0.9});
  for (Eigen::Index i = 0; i < landmarks; ++i) world.landmarks.col(i) << rng.uniform(-12.0, 12.0), rng.uniform(-12.0, 12.0);
  return world;
}

/// What both maps would say about the fused state y (in the layout of `fused`): [x_a; x_b].
Eigen::VectorXd predicted(const Eigen::VectorXd& y, const LiveMap& fused, const LiveMap& a, const LiveMap& b) {
  const auto pose = [&](int base) {
    if (base == a.base) return Se2{};
    return Se2::from_vector(y.segment<3>(3 * *fused.pose_of(base)));
  };
  const auto landmark = [&](const MapLandmark& wanted) -> Eigen::Vector2d {
    for (std::size_t i = 0; i < fused.landmarks.size(); ++i) {
      if (fused.landmarks[i].source_id == wanted.source_id) return y.segment<2>(fused.landmark_offset(static_cast<Eigen::Index>(i)));
    }
    ADD_FAILURE() << "a landmark got lost";
    return Eigen::Vector2d::Zero();
  };
  Eigen::VectorXd z(a.mean.size() + b.mean.size());
  Eigen::Index row = 0;
  for (const LiveMap* map : {&a, &b}) {
    const Se2 map_T_a = pose(map->base).inverse();
    for (const int base : map->poses) {
      z.segment<3>(row) = (map_T_a * pose(base)).vector();
      row += 3;
    }
    for (const MapLandmark& wanted : map->landmarks) {
      z.segment<2>(row) = map_T_a * landmark(wanted);
      row += 2;
    }
  }
  return z;
}

/// The same by batch weighted least squares.
BatchSolution batch_of(const LiveMap& fused, const LiveMap& a, const LiveMap& b) {
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n_a + n_b, n_a + n_b);
  P.topLeftCorner(n_a, n_a) = a.covariance;
  P.bottomRightCorner(n_b, n_b) = b.covariance;
  const auto residual = [&](const Eigen::VectorXd& y) {
    Eigen::VectorXd r = predicted(y, fused, a, b);
    r.head(n_a) -= a.mean;
    r.tail(n_b) -= b.mean;
    for (Eigen::Index i = 0; i < a.pose_count(); ++i) r(3 * i + 2) = wrap_angle(r(3 * i + 2));
    for (Eigen::Index i = 0; i < b.pose_count(); ++i) r(n_a + 3 * i + 2) = wrap_angle(r(n_a + 3 * i + 2));
    return r;
  };
  return solve_batch(fused.mean, residual, P);
}

void expect_batch(const Fusion& fusion, const LiveMap& a, const LiveMap& b, double tolerance = kLinearTolerance) {
  const BatchSolution batch = batch_of(fusion.map, a, b);
  EXPECT_LE(difference_in_sigmas(fusion.map.mean, batch.y, fusion.map.pose_count(), batch.covariance), tolerance);
  EXPECT_LE(covariance_difference(fusion.map.covariance, batch.covariance), tolerance);
  EXPECT_NEAR(fusion.chi_squared, batch.chi_squared, 1e-4 * (1.0 + batch.chi_squared));
}

TEST(Fusion, J8_J12_EqualsBatchLeastSquares) {
  Rng rng(421);
  for (int trial = 0; trial < 5; ++trial) {
    const World world = bent_world(rng, 8, 12);
    const LiveMap a = live_map_of(noisy_submap(world, 1, {0, 1, 2, 3, 4, 5, 6}, kSmallNoise, rng));
    const LiveMap b = live_map_of(noisy_submap(world, 5, {9, 5, 3, 1, 8, 6, 11}, kSmallNoise, rng));
    const Fusion fusion = fuse(a, b, pairs_by_identity(a, b));
    EXPECT_EQ(fusion.map.base, 1);
    EXPECT_EQ(fusion.map.members, (std::vector<int>{1, 5}));
    EXPECT_EQ(fusion.map.poses, (std::vector<int>{2, 5, 6}));
    EXPECT_EQ(fusion.map.landmark_count(), 7 + 7 - 4);
    EXPECT_EQ(fusion.dof, 2 * 4 - 3);
    expect_batch(fusion, a, b);
  }
}

TEST(Fusion, J8_TwoPairsAreJustEnough) {
  Rng rng(422);
  const World world = bent_world(rng, 8, 6);
  const LiveMap a = live_map_of(noisy_submap(world, 0, {0, 1, 2}, 0.25 * kSmallNoise, rng));
  const LiveMap b = live_map_of(noisy_submap(world, 4, {1, 2, 5}, 0.25 * kSmallNoise, rng));
  const Fusion fusion = fuse(a, b, pairs_by_identity(a, b));
  EXPECT_EQ(fusion.dof, 1);
  expect_batch(fusion, a, b);
}

TEST(Fusion, J8_AdjacentMapsAreTiedByTheirSharedBase) {
  Rng rng(423);
  const World world = bent_world(rng, 8, 10);
  const LiveMap a = live_map_of(noisy_submap(world, 2, {0, 1, 2, 3}, kSmallNoise, rng));
  const LiveMap b = live_map_of(noisy_submap(world, 3, {3, 4, 5, 6}, kSmallNoise, rng));
  const Fusion fusion = fuse(a, b, pairs_by_identity(a, b));  // b's own base is a pose of a
  EXPECT_EQ(fusion.map.poses, (std::vector<int>{3, 4}));
  EXPECT_EQ(fusion.dof, 2 * 1 + 3 - 3);
  expect_batch(fusion, a, b);
  const Fusion turned = fuse(b, a, pairs_by_identity(b, a));
  EXPECT_EQ(turned.map.base, 3);
  EXPECT_EQ(turned.map.poses, (std::vector<int>{4, 2}));
  expect_batch(turned, b, a);
}

TEST(Fusion, J12_WithoutPairsAdjacentMapsAreComposed) {
  Rng rng(424);
  const World world = bent_world(rng, 4, 2);
  const LiveMap a = live_map_of(noisy_submap(world, 0, {0}, 0.05, rng));
  const LiveMap b = live_map_of(noisy_submap(world, 1, {1}, 0.05, rng));
  const Fusion fusion = fuse(a, b, {});
  const GaussianSe2 a_T_b{a.base_T_pose(0), a.covariance.topLeftCorner<3, 3>()};
  const GaussianSe2 b_T_exit{b.base_T_pose(0), b.covariance.topLeftCorner<3, 3>()};
  const GaussianSe2 exit = compose_independent(a_T_b, b_T_exit);
  EXPECT_LE((fusion.map.mean.segment<3>(3) - exit.mean.vector()).norm(), 1e-12);
  EXPECT_LE((fusion.map.covariance.block<3, 3>(3, 3) - exit.covariance).cwiseAbs().maxCoeff(), 1e-10);  // 1e-12 times a lever of 10 m
  EXPECT_LE((fusion.map.covariance.topLeftCorner<3, 3>() - a_T_b.covariance).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_NEAR(fusion.chi_squared, 0.0, 1e-12);
  EXPECT_EQ(fusion.dof, 0);
}

/// Fuses in the given order; every base frame stays a pose.
LiveMap fuse_all(std::vector<LiveMap> maps, const std::vector<std::pair<int, int>>& order) {
  for (const auto& [into, from] : order) {
    LiveMap& a = maps[static_cast<std::size_t>(into)];
    const LiveMap& b = maps[static_cast<std::size_t>(from)];
    a = fuse(a, b, pairs_by_identity(a, b)).map;
  }
  return maps[static_cast<std::size_t>(order.back().first)];
}

/// The map's numbers in a fixed order: poses by base (the map's own base is the identity), landmarks by identity, all in the frame of base
/// 0.
struct Ordered {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
Ordered in_order(const LiveMap& map) {
  EXPECT_EQ(map.base, 0);
  std::vector<Eigen::Index> rows;
  for (const int base : std::set<int>(map.poses.begin(), map.poses.end())) {
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * *map.pose_of(base) + c);
  }
  std::map<std::int64_t, Eigen::Index> landmarks;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) landmarks[*map.landmarks[i].source_id] = static_cast<Eigen::Index>(i);
  EXPECT_EQ(landmarks.size(), map.landmarks.size());
  for (const auto& [id, index] : landmarks) {
    for (Eigen::Index c = 0; c < 2; ++c) rows.push_back(map.landmark_offset(index) + c);
  }
  return {map.mean(rows), map.covariance(rows, rows)};
}

TEST(Fusion, J8_J12_OrderDoesNotMatter) {
  constexpr double kTinyNoise = 0.001;
  Rng rng(425);
  const World world = bent_world(rng, 8, 14);
  // maps 0, 2, 3, 6: 2 and 3 are adjacent
  const std::vector<LiveMap> maps{live_map_of(noisy_submap(world, 0, {0, 1, 2, 3, 4, 5}, kTinyNoise, rng)),
                                  live_map_of(noisy_submap(world, 2, {2, 3, 4, 6, 7, 8}, kTinyNoise, rng)),
                                  live_map_of(noisy_submap(world, 3, {0, 4, 8, 9, 10}, kTinyNoise, rng)),
                                  live_map_of(noisy_submap(world, 6, {1, 5, 7, 9, 10, 12, 13}, kTinyNoise, rng))};
  const Ordered reference = in_order(fuse_all(maps, {{0, 1}, {0, 2}, {0, 3}}));
  ASSERT_EQ(reference.mean.size(), 3 * 6 + 2 * 13);
  for (const std::vector<std::pair<int, int>>& order : {std::vector<std::pair<int, int>>{{0, 3}, {0, 2}, {0, 1}},
                                                        {{0, 2}, {0, 3}, {0, 1}},
                                                        {{1, 2}, {1, 3}, {0, 1}},
                                                        {{2, 3}, {0, 1}, {0, 2}}}) {
    const Ordered other = in_order(fuse_all(maps, order));
    // Each order linearises at other points: second-order terms of 1 mm and 0.1 mrad.
    EXPECT_LE(difference_in_sigmas(other.mean, reference.mean, 6, reference.covariance), 2e-3);
    EXPECT_LE(covariance_difference(other.covariance, reference.covariance), 2e-3);
  }
}

TEST(Fusion, J8_RefusionWithSeveralSharedBasesEqualsBatch) {
  Rng rng(426);
  const World world = bent_world(rng, 8, 14);
  // {1, 4} and {2, 5}: the two fused maps share bases 2 and 5, one as a pose of each
  const LiveMap m1 = live_map_of(noisy_submap(world, 1, {0, 1, 2, 3}, kSmallNoise, rng));
  const LiveMap m4 = live_map_of(noisy_submap(world, 4, {1, 2, 3, 9}, kSmallNoise, rng));
  const LiveMap m2 = live_map_of(noisy_submap(world, 2, {4, 5, 6, 7}, kSmallNoise, rng));
  const LiveMap m5 = live_map_of(noisy_submap(world, 5, {5, 6, 7, 9}, kSmallNoise, rng));
  const LiveMap a = fuse(m1, m4, pairs_by_identity(m1, m4)).map;
  const LiveMap b = fuse(m2, m5, pairs_by_identity(m2, m5)).map;
  const Fusion fusion = fuse(a, b, pairs_by_identity(a, b));
  EXPECT_EQ(fusion.map.members, (std::vector<int>{1, 2, 4, 5}));
  EXPECT_EQ(fusion.map.poses, (std::vector<int>{2, 4, 5, 3, 6}));
  EXPECT_EQ(fusion.dof, 2 * 1 + 3 * 2 - 3);
  expect_batch(fusion, a, b);
}

TEST(Fusion, KeepsWhatIsKnownAboutLandmarks) {
  Rng rng(427);
  const World world = bent_world(rng, 4, 4);
  LiveMap a = live_map_of(noisy_submap(world, 0, {0, 1, 2}, kSmallNoise, rng));
  LiveMap b = live_map_of(noisy_submap(world, 2, {2, 1, 3}, kSmallNoise, rng));
  const std::vector<Pair> pairs = pairs_by_identity(a, b);
  a.landmarks[1].times_seen = 4;
  b.landmarks[1].times_seen = 3;
  a.landmarks[2].source_id.reset();
  const Fusion fusion = fuse(a, b, pairs);
  ASSERT_EQ(fusion.map.landmarks.size(), 4U);
  EXPECT_EQ(fusion.map.landmarks[1].times_seen, 7);
  EXPECT_EQ(fusion.map.landmarks[2].source_id, 2);  // b knows it
  EXPECT_EQ(fusion.map.landmarks[3].source_id, 3);
}

TEST(Fusion, DegenerateInputsAreRefused) {
  Rng rng(428);
  World world = bent_world(rng, 8, 6);
  world.landmarks.col(1) = world.landmarks.col(0);
  const LiveMap a = live_map_of(noisy_submap(world, 1, {0, 1, 2}, kSmallNoise, rng));
  LiveMap b = live_map_of(noisy_submap(world, 5, {0, 1, 2}, kSmallNoise, rng));
  LiveMap same_place = a;
  for (LiveMap* map : {&same_place, &b}) map->mean.segment<2>(5) = map->mean.segment<2>(3);  // exactly one on the other
  const auto refused = [&](const LiveMap& first, const LiveMap& second, const std::vector<Pair>& pairs) {
    try {
      (void)fuse(first, second, pairs);
      ADD_FAILURE() << "fused on " << pairs.size() << " pairs";
    } catch (const NotPositiveDefinite& error) {
      EXPECT_NE(std::string(error.what()).find("relative pose is not positive definite (maps at bases 1 and 5"), std::string::npos)
          << error.what();
    }
  };
  refused(a, b, {});
  refused(a, b, {{2, 2}});
  refused(same_place, b, {{0, 0}, {1, 1}});
}

TEST(Fusion, NotPositiveDefiniteNamesTheMaps) {
  Rng rng(429);
  const World world = bent_world(rng, 8, 6);
  LiveMap a = live_map_of(noisy_submap(world, 1, {0, 1, 2}, kSmallNoise, rng));
  const LiveMap b = live_map_of(noisy_submap(world, 5, {0, 1, 2}, kSmallNoise, rng));
  a.covariance.bottomRightCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  try {
    (void)fuse(a, b, pairs_by_identity(a, b));
    FAIL() << "a negative variance was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(std::string(error.what()), "constraint covariance is not positive definite (fusion of the maps at bases 1 and 5)");
  }
}

TEST(Fusion, J9_J11_CostAndErrorAreAsLargeAsTheyClaim) {
  // Maps with decimetre noise, each pair drawn anew: the cost is chi-squared with its degrees of freedom, the error of the fused state
  // too. The band is two-sided at 99.9 %.
  constexpr int kRuns = 400;
  Rng rng(430);
  double chi_squared = 0.0;
  double nees = 0.0;
  int dof = 0;
  int state_size = 0;
  for (int run = 0; run < kRuns; ++run) {
    const World world = bent_world(rng, 8, 12);
    const LiveMap a = live_map_of(noisy_submap(world, 1, {0, 1, 2, 3, 4, 5, 6}, 0.1, rng));
    const LiveMap b = live_map_of(noisy_submap(world, 5, {1, 2, 4, 5, 6, 9, 10, 11}, 0.1, rng));
    const Fusion fusion = fuse(a, b, pairs_by_identity(a, b));
    chi_squared += fusion.chi_squared;
    dof = fusion.dof;
    const Se2 a_T_global = world.global_T_base[1].inverse();
    Eigen::VectorXd error = fusion.map.mean;
    for (Eigen::Index i = 0; i < fusion.map.pose_count(); ++i) {
      const Se2 truth = a_T_global * world.global_T_base[static_cast<std::size_t>(fusion.map.poses[static_cast<std::size_t>(i)])];
      error.segment<3>(3 * i) = additive_difference(fusion.map.base_T_pose(i), truth);
    }
    for (Eigen::Index i = 0; i < fusion.map.landmark_count(); ++i) {
      const auto id = *fusion.map.landmarks[static_cast<std::size_t>(i)].source_id;
      error.segment<2>(fusion.map.landmark_offset(i)) -= a_T_global * Eigen::Vector2d(world.landmarks.col(id));
    }
    state_size = static_cast<int>(error.size());
    nees += normalized_squared_error(error, fusion.map.covariance);
  }
  const Band cost_band = mean_band(dof, kRuns, 0.999);
  EXPECT_EQ(dof, 7);
  EXPECT_GE(chi_squared / kRuns, cost_band.lower);
  EXPECT_LE(chi_squared / kRuns, cost_band.upper);
  const Band nees_band = mean_band(state_size, kRuns, 0.999);
  EXPECT_GE(nees / kRuns, nees_band.lower);
  EXPECT_LE(nees / kRuns, nees_band.upper);
  RecordProperty("cost_per_dof", std::to_string(chi_squared / kRuns / dof));
  RecordProperty("nees_per_dof", std::to_string(nees / kRuns / state_size));
}

}  // namespace
}  // namespace ssjs
