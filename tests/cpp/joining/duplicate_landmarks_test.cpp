#include "ssjs/joining/duplicate_landmarks.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

/// One pose and landmarks at the given places, correlated, each about `sigma_m` sure.
LiveMap map_of(const std::vector<Eigen::Vector2d>& places, double sigma_m, Rng& rng) {
  LiveMap map;
  map.poses = {1};
  map.members = {0};
  const auto n = static_cast<Eigen::Index>(3 + 2 * places.size());
  map.mean.resize(n);
  map.mean.head<3>() << 20.0, 1.0, 0.3;
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(n, sigma_m);
  sigmas(2) = 0.1 * sigma_m;
  for (std::size_t i = 0; i < places.size(); ++i) {
    map.mean.segment<2>(static_cast<Eigen::Index>(3 + 2 * i)) = places[i];
    map.landmarks.push_back({static_cast<int>(i + 1), static_cast<std::int64_t>(i), {static_cast<std::int64_t>(10 + i)}});
  }
  map.covariance = testing::correlated_covariance(rng, sigmas);
  return map;
}

MapAssociator gated(double gate_m, AssociationMethod method = AssociationMethod::kJointCompatibility) {
  return MapAssociator({method, {}, gate_m, std::nullopt}, 1);
}

TEST(DuplicateLandmarks, L5_MergingIsTheWeightedEstimateUnderTheEquality) {
  // x = A y with one place for both copies: y = (A' P^-1 A)^-1 A' P^-1 x.
  Rng rng(571);
  LiveMap map = map_of({{0.0, 0.0}, {5.0, 0.0}, {0.1, 0.2}, {9.0, 3.0}, {5.2, -0.1}}, 0.3, rng);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(13, 9);
  A.topLeftCorner<3, 3>().setIdentity();
  const int place_of[] = {0, 1, 0, 2, 1};
  for (Eigen::Index i = 0; i < 5; ++i) A.block<2, 2>(3 + 2 * i, 3 + 2 * place_of[i]).setIdentity();
  const Eigen::MatrixXd information = map.covariance.inverse();
  const Eigen::MatrixXd P = (A.transpose() * information * A).inverse();
  const Eigen::VectorXd y = P * A.transpose() * information * map.mean;
  const Eigen::VectorXd left = map.mean - A * y;
  const double expected_chi_squared = left.dot(information * left);

  const double chi_squared = merge_duplicates(map, {{2, 0}, {4, 1}});
  ASSERT_EQ(map.landmark_count(), 3);
  EXPECT_LE((map.mean - y).cwiseQuotient(P.diagonal().cwiseSqrt()).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LE(testing::covariance_difference(map.covariance, P), 1e-6);
  EXPECT_NEAR(chi_squared, expected_chi_squared, 1e-6 * expected_chi_squared);
  EXPECT_EQ(map.covariance, map.covariance.transpose());
  EXPECT_EQ(map.landmarks[0].times_seen, 1 + 3);
  EXPECT_EQ(map.landmarks[0].tracks, (std::vector<std::int64_t>{10, 12}));
  EXPECT_EQ(map.landmarks[1].tracks, (std::vector<std::int64_t>{11, 14}));
  EXPECT_EQ(*map.landmarks[2].source_id, 3);
}

TEST(DuplicateLandmarks, L5_NothingToMergeChangesNothing) {
  Rng rng(572);
  LiveMap map = map_of({{0.0, 0.0}, {5.0, 0.0}}, 0.3, rng);
  const LiveMap before = map;
  EXPECT_EQ(merge_duplicates(map, {}), 0.0);
  EXPECT_EQ(map.covariance, before.covariance);
}

TEST(DuplicateLandmarks, L5_CopiesAreFoundUnlessUnsureOrKnownToDiffer) {
  Rng rng(573);
  // landmarks 4 and 5 were seen just now; 0 and 4 stand 0.15 m apart, 2 and 5 are 0.1 m apart, 1 and 3 are nobody's copies
  LiveMap map = map_of({{0.0, 0.0}, {5.0, 0.0}, {10.0, 0.0}, {15.0, 0.0}, {0.15, 0.0}, {10.0, 0.1}}, 0.1, rng);
  const auto nothing_known = [](Eigen::Index, Eigen::Index) { return false; };
  MapAssociator associator = gated(0.8);
  const std::vector<Pair> both{{4, 0}, {5, 2}};
  EXPECT_EQ(find_duplicates(map, {4, 5}, nothing_known, associator).pairs, both);
  const auto differ = [](Eigen::Index i, Eigen::Index j) { return i == 4 && j == 0; };
  EXPECT_EQ(find_duplicates(map, {4, 5}, differ, associator).pairs, (std::vector<Pair>{{5, 2}}));
  EXPECT_TRUE(find_duplicates(map, {1, 3}, nothing_known, associator).pairs.empty());
  EXPECT_TRUE(find_duplicates(map, {0, 1, 2, 3, 4, 5}, nothing_known, associator).pairs.empty());  // nothing else is in the map
  MapAssociator strict = gated(0.05);
  EXPECT_TRUE(find_duplicates(map, {4, 5}, nothing_known, strict).pairs.empty());
  MapAssociator known = gated(0.8, AssociationMethod::kKnown);
  EXPECT_TRUE(find_duplicates(map, {4, 5}, nothing_known, known).pairs.empty());
}

}  // namespace
}  // namespace ssjs
