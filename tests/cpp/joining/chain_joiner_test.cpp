#include "ssjs/joining/chain_joiner.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "joining/linear_world.hpp"
#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/joining/constrained_local.hpp"
#include "ssjs/joining/divide_and_conquer.hpp"
#include "ssjs/joining/sequential.hpp"

namespace ssjs {
namespace {

using testing::LinearBatch;
using testing::LinearWorld;
using testing::noisy_submap;
using testing::World;

constexpr double kExact = 1e-9;  // of a standard deviation

MapAssociator associator_of(AssociationMethod method) { return MapAssociator({method, {}, std::nullopt, std::nullopt}, 1); }
MapAssociator known() { return associator_of(AssociationMethod::kKnown); }

/// The positions of a joined map against the batch: exit, landmarks and all their correlations, in standard deviations.
void expect_batch(const ChainedMap& joined, const LinearBatch& batch) {
  const LiveMap& map = joined.map;
  ASSERT_EQ(map.landmarks.size(), batch.landmark_at.size());  // nothing stands in it twice
  std::vector<int> rows{0, 1};
  std::vector<Eigen::Index> columns{LinearBatch::base_at(batch.bases), LinearBatch::base_at(batch.bases) + 1};
  for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
    const Eigen::Index at = batch.landmark_at.at(static_cast<int>(*map.landmarks[static_cast<std::size_t>(i)].source_id));
    for (int c = 0; c < 2; ++c) {
      rows.push_back(static_cast<int>(map.landmark_offset(i)) + c);
      columns.push_back(at + c);
    }
  }
  const Eigen::MatrixXd P = batch.covariance(columns, columns);
  EXPECT_LE(testing::difference_in_sigmas(map.mean(rows), batch.y(columns), 0, P), kExact);
  EXPECT_LE(testing::covariance_difference(map.covariance(rows, rows), P), kExact);
}

TEST(ChainJoiner, L2_D1_K2_EveryOrderOfJoinsIsTheBatch) {
  Rng rng(501);
  for (const int count : {2, 5, 8, 13}) {
    const LinearWorld world(count, rng);
    const LinearBatch batch(world, count);
    SequentialJoiner sequential(known());
    DivideAndConquerJoiner divided(known());
    ConstrainedLocalJoiner constrained(known());
    for (ChainJoiner* const joiner :
         {static_cast<ChainJoiner*>(&sequential), static_cast<ChainJoiner*>(&divided), static_cast<ChainJoiner*>(&constrained)}) {
      int fusions = 0;
      for (const Submap& submap : world.submaps) fusions += joiner->take(submap).fusions;
      fusions += joiner->finish().fusions;
      EXPECT_EQ(fusions, count - 1);
      ASSERT_EQ(joiner->stack().size(), 1U);
      expect_batch(joiner->stack().front(), batch);
    }
    for (int order = 0; order < 5; ++order) {  // neighbours at random until one map is left
      std::vector<ChainedMap> chain;
      for (const Submap& submap : world.submaps) chain.push_back(chained_map_of(submap));
      MapAssociator associator = known();
      JoinReport report;
      while (chain.size() > 1) {
        const auto left = static_cast<std::ptrdiff_t>(rng.below(chain.size() - 1));
        const auto at = static_cast<std::size_t>(left);
        chain[at] = join_neighbours(chain[at], chain[at + 1], order % 2 == 0 ? &fuse : &project, associator, report);
        chain.erase(chain.begin() + left + 1);
      }
      expect_batch(chain.front(), batch);
    }
  }
}

TEST(ChainJoiner, D1_TheStackIsABinaryCounter) {
  Rng rng(502);
  const LinearWorld world(13, rng);
  DivideAndConquerJoiner joiner(known());
  for (std::size_t k = 0; k < world.submaps.size(); ++k) {
    (void)joiner.take(world.submaps[k]);
    std::size_t rest = k + 1;  // the weights are the powers of two that make up k + 1
    for (auto chained = joiner.stack().rbegin(); chained != joiner.stack().rend(); ++chained) {
      const std::size_t weight = chained->map.members.size();
      EXPECT_EQ(weight, rest & (~rest + 1));  // its lowest bit
      rest -= weight;
    }
    EXPECT_EQ(rest, 0U);
  }
}

TEST(ChainJoiner, L2_TheOnlinePoseIsTheChainOverTheStack) {
  // Between collapses divide and conquer does not know yet what distant submaps have in common: its pose is the chain of maps that are
  // each the batch of their own submaps. Right after a collapse to one map it is the batch of everything.
  Rng rng(503);
  const LinearWorld world(9, rng);
  DivideAndConquerJoiner joiner(known());
  for (int k = 0; k < 9; ++k) {
    (void)joiner.take(world.submaps[static_cast<std::size_t>(k)]);
    const GaussianSe2 pose = joiner.global_T_newest_base();
    if (k != 3 && k != 7) continue;
    const LinearBatch batch(world, k + 1);
    const Eigen::Index at = LinearBatch::base_at(k + 1);
    const Eigen::MatrixXd P = batch.covariance.block<2, 2>(at, at);
    EXPECT_LE(testing::difference_in_sigmas(pose.mean.translation(), batch.y.segment<2>(at), 0, P), kExact);
    EXPECT_LE(testing::covariance_difference(pose.covariance.topLeftCorner<2, 2>(), P), kExact);
  }
  ASSERT_EQ(joiner.stack().size(), 2U);
  const LiveMap& first = joiner.stack()[0].map;
  const LiveMap& second = joiner.stack()[1].map;
  const GaussianSe2 chain = compose_independent({first.base_T_pose(0), first.covariance.topLeftCorner<3, 3>()},
                                                {second.base_T_pose(0), second.covariance.topLeftCorner<3, 3>()});
  EXPECT_EQ(joiner.global_T_newest_base().mean.vector(), chain.mean.vector());
  EXPECT_EQ(joiner.global_T_newest_base().covariance, chain.covariance);
}

TEST(ChainJoiner, L4_BordersAreTheBatchOfTheirTime) {
  Rng rng(504);
  const LinearWorld world(9, rng);
  for (const bool constrained : {false, true}) {
    std::unique_ptr<ChainJoiner> joiner;
    if (constrained) {
      joiner = std::make_unique<ConstrainedLocalJoiner>(known());
    } else {
      joiner = std::make_unique<SequentialJoiner>(known());
    }
    for (const Submap& submap : world.submaps) (void)joiner->take(submap);
    const WorldEstimate estimate = joiner->estimate(BaseCovariance::kJoint);
    EXPECT_EQ(estimate.base_covariance.size(), 0);
    ASSERT_EQ(estimate.global_T_base.size(), 10U);
    ASSERT_EQ(estimate.border_covariance.size(), 9U);
    EXPECT_EQ(estimate.border_covariance[0].topRows<3>().cwiseAbs().maxCoeff(), 0.0);
    for (int k = 1; k < 9; ++k) {  // bases k and k + 1 were last in the state together when submap k was joined
      const LinearBatch batch(world, k + 1);
      const Eigen::Index at = LinearBatch::base_at(k);
      const std::vector<int> rows{0, 1, 3, 4};
      const Eigen::MatrixXd P = batch.covariance.block<4, 4>(at, at);
      EXPECT_LE(testing::covariance_difference(estimate.border_covariance[static_cast<std::size_t>(k)](rows, rows), P), kExact) << k;
      EXPECT_LE(testing::difference_in_sigmas(estimate.global_T_base[static_cast<std::size_t>(k)].translation(), batch.y.segment<2>(at), 0,
                                              P.topLeftCorner<2, 2>()),
                kExact);
    }
  }
}

/// A straight drive past a band of landmarks, out and back, with noise that turns it.
struct OutAndBack {
  World truth{{Se2{}}, Eigen::Matrix2Xd(2, 60)};
  std::vector<std::vector<int>> seen;

  OutAndBack() {
    Rng rng(505);
    for (int k = 0; k < 12; ++k) {
      const Se2 turn{0.0, 0.0, k == 5 ? kPi : 0.0};
      truth.global_T_base.push_back(truth.global_T_base.back() * Se2{8.0, 0.0, 0.0} * turn);
    }
    for (Eigen::Index i = 0; i < 60; ++i) truth.landmarks.col(i) << 0.8 * static_cast<double>(i), rng.uniform(-6.0, 6.0);
    for (int k = 0; k < 12; ++k) {
      const double middle = 8.0 * (k < 6 ? k : 11 - k) + 4.0;
      seen.emplace_back();
      for (int i = 0; i < 60; ++i) {
        if (std::abs(truth.landmarks(0, i) - middle) < 5.5) seen.back().push_back(i);
      }
    }
  }
  [[nodiscard]] std::vector<Submap> draw(double sigma_m, Rng& rng) const {
    std::vector<Submap> submaps;
    for (int k = 0; k < 12; ++k) submaps.push_back(noisy_submap(truth, k, seen[static_cast<std::size_t>(k)], sigma_m, rng));
    return submaps;
  }
};

TEST(ChainJoiner, L4_BordersAndLandmarksAreAsFarOffAsTheySay) {
  constexpr int kRuns = 60;
  const OutAndBack drive;
  Rng rng(506);
  for (const int method : {0, 1, 2}) {
    double base_nees = 0.0, border_nees = 0.0, landmark_nees = 0.0;
    int landmarks = 0;
    for (int run = 0; run < kRuns; ++run) {
      std::unique_ptr<ChainJoiner> joiner;
      if (method == 0) joiner = std::make_unique<SequentialJoiner>(known());
      if (method == 1) joiner = std::make_unique<DivideAndConquerJoiner>(known());
      if (method == 2) joiner = std::make_unique<ConstrainedLocalJoiner>(known());
      for (const Submap& submap : drive.draw(0.03, rng)) (void)joiner->take(submap);
      (void)joiner->finish();
      const WorldEstimate world = joiner->estimate(BaseCovariance::kBorders);
      for (std::size_t k = 1; k < 12; ++k) {
        const Eigen::Vector3d error = additive_difference(world.global_T_base[k], drive.truth.global_T_base[k]);
        base_nees += normalized_squared_error(error, world.border_covariance[k].topLeftCorner<3, 3>()) / (11 * kRuns);
      }
      Eigen::Matrix<double, 6, 1> error;  // of the last border, whose end is in the state
      error << additive_difference(world.global_T_base[11], drive.truth.global_T_base[11]),
          additive_difference(world.global_T_base[12], drive.truth.global_T_base[12]);
      border_nees += normalized_squared_error(error, world.border_covariance[11]) / kRuns;
      for (const LandmarkEstimate& landmark : world.landmarks) {
        const Eigen::Vector2d off = landmark.position.mean - drive.truth.landmarks.col(*landmark.landmark.source_id);
        landmark_nees += normalized_squared_error(off, landmark.position.covariance);
        ++landmarks;
      }
    }
    // means over 60 runs that are correlated within a run: 3 +- 0.4 for one, 6 +- 0.5 for the border
    EXPECT_GE(base_nees, 2.2) << method;
    EXPECT_LE(base_nees, 3.9) << method;
    EXPECT_GE(border_nees, 4.5) << method;
    EXPECT_LE(border_nees, 7.5) << method;
    EXPECT_GE(landmark_nees / landmarks, 1.5) << method;
    EXPECT_LE(landmark_nees / landmarks, 2.6) << method;
  }
}

TEST(ChainJoiner, L2_K1_NeighboursWithNothingInCommonAreSetSideBySide) {
  const OutAndBack drive;
  Rng rng(509);
  std::vector<int> of_first, of_second;
  for (int i = 0; i < 60; ++i) (i < 32 ? of_first : of_second).push_back(i);
  const Submap first = noisy_submap(drive.truth, 0, of_first, 0.03, rng);
  const Submap second = noisy_submap(drive.truth, 1, of_second, 0.03, rng);
  const GaussianSe2 exit = compose_independent(first.state.vehicle(), second.state.vehicle());
  for (const MergeNeighbours merge : {MergeNeighbours{&fuse}, MergeNeighbours{&project}}) {
    MapAssociator associator = known();
    JoinReport report;
    const ChainedMap joined = join_neighbours(chained_map_of(first), chained_map_of(second), merge, associator, report);
    ASSERT_EQ(joined.map.landmark_count(), 60);
    EXPECT_EQ(report.neighbours.front().pairs, 0);
    EXPECT_LE(additive_difference(joined.map.base_T_pose(0), exit.mean).norm(), 1e-9);
    EXPECT_LE(testing::covariance_difference(joined.map.covariance.topLeftCorner<3, 3>(), exit.covariance), 1e-5);
    for (Eigen::Index i = 0; i < 60; ++i) {
      const Eigen::Vector2d own = (i < 32 ? first : second).state.mean.segment<2>(3 + 2 * (i < 32 ? i : i - 32));
      const Eigen::Vector2d expected = i < 32 ? own : first.state.vehicle().mean * own;
      EXPECT_LE((joined.map.mean(joined.map.landmark(i)) - expected).norm(), 1e-9);
    }
  }
}

TEST(ChainJoiner, FindsThePairsWithoutIdentities) {
  const OutAndBack drive;
  Rng rng(507);
  const std::vector<Submap> submaps = drive.draw(0.02, rng);
  for (const AssociationMethod method :
       {AssociationMethod::kNearestNeighbour, AssociationMethod::kJointCompatibility, AssociationMethod::kRandomizedJointCompatibility}) {
    SequentialJoiner joiner(associator_of(method));
    int pairs = 0, wrong = 0, expected = 0;
    std::vector<bool> known_before(60, false);
    for (const Submap& submap : submaps) {
      const JoinReport report = joiner.take(submap);
      for (const NeighbourJoin& join : report.neighbours) {
        pairs += join.pairs;
        wrong += join.wrong_pairs.value_or(1000);
        EXPECT_EQ(join.from, 0);
        EXPECT_EQ(join.to, submap.index);
        EXPECT_GT(join.dof, 0);
      }
      EXPECT_TRUE(report.loops.empty());
      for (const MapLandmark& landmark : submap.landmarks) {
        expected += known_before[static_cast<std::size_t>(*landmark.source_id)] ? 1 : 0;
        known_before[static_cast<std::size_t>(*landmark.source_id)] = true;
      }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GE(pairs, expected * 95 / 100);
  }
}

TEST(ChainJoiner, L5_WhatWasAmbiguousIsMergedWhenItNoLongerIs) {
  // The links are as unsure as the gate is wide: one landmark in seven is entered twice by the joins alone.
  const OutAndBack drive;
  Rng rng(510);
  int twice = 0, wrong = 0, merged = 0, landmarks = 0;
  for (int run = 0; run < 10; ++run) {
    SequentialJoiner joiner(MapAssociator({AssociationMethod::kJointCompatibility, {}, 0.2, std::nullopt}, 1));
    JoinReport report;
    for (const Submap& submap : drive.draw(0.1, rng)) report.append(joiner.take(submap));
    report.append(joiner.finish());
    for (const NeighbourJoin& join : report.neighbours) {
      wrong += join.wrong_pairs.value_or(1000);
      EXPECT_GE(join.dof, 2 * join.pairs);
    }
    std::map<std::int64_t, int> copies;
    int sightings = 0;
    const WorldEstimate world = joiner.estimate(BaseCovariance::kBorders);
    for (const LandmarkEstimate& landmark : world.landmarks) {
      ++copies[*landmark.landmark.source_id];
      sightings += landmark.landmark.times_seen;
      merged += landmark.landmark.tracks.size() > 1 ? 1 : 0;
    }
    for (const auto& [id, count] : copies) twice += count - 1;
    landmarks += static_cast<int>(copies.size());
    int expected = 0;
    for (const auto& ids : drive.seen) expected += static_cast<int>(ids.size());
    EXPECT_EQ(sightings, expected);  // no sighting is lost
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(merged, landmarks / 2);
  EXPECT_LE(twice, landmarks / 100) << twice << " of " << landmarks;
}

TEST(ChainJoiner, AmbiguousPairsAreLeftOut) {
  // Fifty metres out and back with links of 0.3 m and 0.03 rad: the way back is metres away from the way out, the last submap is not.
  const OutAndBack drive;
  Rng rng(508);
  const std::vector<Submap> submaps = drive.draw(0.3, rng);
  const auto pairs_within = [&](std::optional<double> gate_m) {
    SequentialJoiner joiner(MapAssociator({AssociationMethod::kNearestNeighbour, {}, gate_m, std::nullopt}, 1));
    int pairs = 0;
    for (const Submap& submap : submaps) {
      for (const NeighbourJoin& join : joiner.take(submap).neighbours) pairs += join.pairs;
    }
    return pairs;
  };
  const int open = pairs_within(std::nullopt);
  const int gated = pairs_within(0.45);
  EXPECT_GT(gated, 0);
  EXPECT_LT(gated, open);
  EXPECT_EQ(pairs_within(0.01), 0);  // the landmarks themselves are not so sure
}

}  // namespace
}  // namespace ssjs
