#include "ssjs/joining/consistent_set.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using Edges = std::vector<std::pair<std::size_t, std::size_t>>;

bool contradicts_itself(const std::vector<bool>& kept, const Edges& edges) {
  for (const auto& [a, b] : edges) {
    if (kept[a] && kept[b]) return true;
  }
  return false;
}

/// All subsets.
double brute_force(const std::vector<double>& weights, const Edges& edges) {
  double best = 0.0;
  for (std::size_t set = 0; set < std::size_t{1} << weights.size(); ++set) {
    std::vector<bool> kept(weights.size());
    double weight = 0.0;
    for (std::size_t v = 0; v < weights.size(); ++v) {
      kept[v] = (set >> v & 1U) != 0U;
      weight += kept[v] ? weights[v] : 0.0;
    }
    if (weight > best && !contradicts_itself(kept, edges)) best = weight;
  }
  return best;
}

Edges random_edges(Rng& rng, std::size_t count, double density) {
  Edges edges;
  for (std::size_t b = 0; b < count; ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (rng.uniform() < density) edges.emplace_back(a, b);
    }
  }
  return edges;
}

TEST(ConsistentSet, C7_EqualsTheBestOfAllSubsets) {
  Rng rng(1);
  for (int trial = 0; trial < 300; ++trial) {
    const auto count = static_cast<std::size_t>(1 + trial % 14);
    std::vector<double> weights;
    for (std::size_t v = 0; v < count; ++v) weights.push_back(trial % 2 == 0 ? 1.0 : rng.uniform(0.1, 3.0));
    const Edges edges = random_edges(rng, count, rng.uniform(0.05, 0.9));
    const ConsistentSet found = heaviest_consistent_set(weights, edges, 100000);
    EXPECT_TRUE(found.exact);
    EXPECT_FALSE(contradicts_itself(found.kept, edges));
    EXPECT_NEAR(found.weight, brute_force(weights, edges), 1e-12);
  }
}

TEST(ConsistentSet, AGroupOfThreeLosesAgainstFour) {
  Edges edges;  // 0..3 true, 4..6 agree with each other and with none of the true ones
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = 4; b < 7; ++b) edges.emplace_back(a, b);
  }
  const ConsistentSet found = heaviest_consistent_set(std::vector<double>(7, 1.0), edges, 1000);
  EXPECT_EQ(found.kept, (std::vector<bool>{true, true, true, true, false, false, false}));
  std::vector<double> weighted(7, 1.0);
  weighted[5] = 2.5;
  EXPECT_EQ(heaviest_consistent_set(weighted, edges, 1000).kept, (std::vector<bool>{false, false, false, false, true, true, true}));
}

TEST(ConsistentSet, ThousandsWithScatteredContradictionsAreSearchedExactly) {
  Rng rng(2);
  const std::size_t count = 3000;
  std::vector<double> weights(count, 1.0);
  Edges edges;
  std::size_t false_ones = 0;
  for (std::size_t v = 0; v < count; v += 3) {  // every third is false and contradicts twenty around it that are not
    ++false_ones;
    for (std::size_t i = 1; i < 31 && v + i < count; ++i) {
      if ((v + i) % 3 != 0) edges.emplace_back(v, v + i);
    }
  }
  const ConsistentSet found = heaviest_consistent_set(weights, edges, 100000);
  EXPECT_TRUE(found.exact);
  EXPECT_DOUBLE_EQ(found.weight, static_cast<double>(count - false_ones));
}

TEST(ConsistentSet, ASpentBudgetLeavesAConsistentSet) {
  Rng rng(3);
  const std::size_t count = 120;
  const Edges edges = random_edges(rng, count, 0.3);
  std::vector<double> weights;
  for (std::size_t v = 0; v < count; ++v) weights.push_back(rng.uniform(0.5, 1.5));
  const ConsistentSet found = heaviest_consistent_set(weights, edges, 10);
  EXPECT_FALSE(found.exact);
  EXPECT_FALSE(contradicts_itself(found.kept, edges));
  EXPECT_GE(found.weight, 5.0);
  EXPECT_EQ(found.kept, heaviest_consistent_set(weights, edges, 10).kept);
}

TEST(ConsistentSet, WhatIsNoGraphIsRefused) {
  EXPECT_THROW(static_cast<void>(heaviest_consistent_set({1.0}, {{0, 1}}, 10)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(heaviest_consistent_set({1.0, 1.0}, {{1, 1}}, 10)), InvalidArgument);
  EXPECT_THROW(static_cast<void>(heaviest_consistent_set({1.0, 0.0}, {}, 10)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
