#include "ssjs/joining/map_association.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

LiveMap map_of(const std::vector<std::optional<std::int64_t>>& ids) {
  LiveMap map;
  for (const auto& id : ids) map.landmarks.push_back({1, id});
  return map;
}

TEST(MapAssociation, PairsByIdentityOneToOne) {
  const LiveMap a = map_of({7, 3, std::nullopt, 3, 9});
  const LiveMap b = map_of({3, 3, 3, std::nullopt, 7, 1});
  const std::vector<Pair> expected{{0, 1}, {4, 0}};  // a's second 3 is left: one landmark should not stand twice in a map
  EXPECT_EQ(pair_by_identity(a, b), expected);
}

TEST(MapAssociation, CountsWrongPairsOnlyWhereAllAreKnown) {
  const LiveMap a = map_of({1, 2, std::nullopt});
  const LiveMap b = map_of({1, 3, 4});
  EXPECT_EQ(count_wrong_pairs({{0, 0}, {1, 1}}, a, b), 1);
  EXPECT_EQ(count_wrong_pairs({}, a, b), 0);
  EXPECT_EQ(count_wrong_pairs({{0, 0}, {2, 2}}, a, b), std::nullopt);
}

/// n landmarks in both maps at the same places, 5 m apart, 0.1 m known.
PairingProblem same_places(Eigen::Index n) {
  PairingProblem problem;
  problem.observed.resize(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) problem.observed.segment<2>(2 * i) << 5.0 * static_cast<double>(i), 0.0;
  problem.predicted = problem.observed;
  problem.observed_covariance = problem.predicted_covariance = 0.01 * Eigen::MatrixXd::Identity(2 * n, 2 * n);
  return problem;
}

TEST(MapAssociation, EveryMethodFindsWhatIsPlain) {
  const PairingProblem problem = same_places(12);
  for (const AssociationMethod method :
       {AssociationMethod::kNearestNeighbour, AssociationMethod::kJointCompatibility, AssociationMethod::kRandomizedJointCompatibility}) {
    MapAssociator associator({method, {}, 0.8, std::nullopt}, 1);
    EXPECT_FALSE(associator.identities_are_known());
    EXPECT_EQ(associator.ambiguity_gate(), 0.8);
    const Hypothesis found = associator.associate(problem);
    ASSERT_EQ(found.pairs.size(), 12U);
    for (const Pair& pair : found.pairs) EXPECT_EQ(pair.observation, pair.prediction);
    EXPECT_EQ(associator.associate_exactly(problem).pairs, found.pairs);
  }
  const MapAssociator known({AssociationMethod::kKnown, {}, 0.8, std::nullopt}, 1);
  EXPECT_FALSE(known.ambiguity_gate().has_value());
}

TEST(MapAssociation, LargeProblemsAreRandomised) {
  // The search over all 12 observations visits a node each at least; a sample of four and nearest neighbours need fewer.
  MapAssociator exact({AssociationMethod::kJointCompatibility, {}, std::nullopt, 12}, 1);
  MapAssociator randomized({AssociationMethod::kJointCompatibility, {}, std::nullopt, 11}, 1);
  const PairingProblem problem = same_places(12);
  const Hypothesis of_exact = exact.associate(problem);
  const Hypothesis of_randomized = randomized.associate(problem);
  EXPECT_EQ(of_exact.nodes_visited, exact.associate_exactly(problem).nodes_visited);
  EXPECT_NE(of_randomized.nodes_visited, of_exact.nodes_visited);
  EXPECT_EQ(of_randomized.pairs, of_exact.pairs);
}

}  // namespace
}  // namespace ssjs
