#include "ssjs/joining/relative_joiner.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>

#include "joining/laps.hpp"
#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/joining/fusion.hpp"
#include "ssjs/joining/hierarchical.hpp"
#include "ssjs/joining/selective_thesis.hpp"

namespace ssjs {
namespace {

using testing::BatchSolution;
using testing::Laps;
using testing::solve_batch;

TEST(HierarchicalJoiner, H1_H3_EqualsItsBatchDefinition) {
  // Links with the relative poses that matched maps give, as one least-squares problem: the accepted loops tell which.
  Rng rng(541);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.001, rng);
  HierarchicalJoiner joiner({}, AssociationMethod::kKnown, 15, 1);
  std::vector<LoopAttempt> loops;
  for (const Submap& submap : submaps) {
    const JoinReport report = joiner.take(submap);
    EXPECT_EQ(report.fusions, 0);
    for (const LoopAttempt& loop : report.loops) {
      if (loop.accepted) loops.push_back(loop);
    }
  }
  ASSERT_GE(loops.size(), 10U);
  EXPECT_EQ(joiner.maps().size(), submaps.size());  // nothing is merged

  const Eigen::Index n = 3 * 20;
  const Eigen::Index rows = n + 3 * static_cast<Eigen::Index>(loops.size());
  Eigen::VectorXd z(rows);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t k = 0; k < submaps.size(); ++k) {
    const LiveMap map = live_map_of(submaps[k]);
    z.segment<3>(static_cast<Eigen::Index>(3 * k)) = map.mean.head<3>();
    P.block<3, 3>(static_cast<Eigen::Index>(3 * k), static_cast<Eigen::Index>(3 * k)) = map.covariance.topLeftCorner<3, 3>();
  }
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const LiveMap& a = joiner.maps().at(loops[l].to);
    const LiveMap& b = joiner.maps().at(loops[l].from);
    const Fusion match = fuse(a, b, testing::pairs_by_identity(a, b));
    const Eigen::Index at = n + static_cast<Eigen::Index>(3 * l);
    z.segment<3>(at) = match.map.mean.head<3>();
    P.block<3, 3>(at, at) = match.map.covariance.topLeftCorner<3, 3>();
  }
  const auto residual = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd r(rows);
    const auto chain = [&](int i, int j) {
      Se2 tau;
      for (int k = i; k < j; ++k) tau = tau * Se2::from_vector(x.segment<3>(3 * Eigen::Index{k}));
      return tau;
    };
    for (int k = 0; k < 20; ++k)
      r.segment<3>(3 * Eigen::Index{k}) = additive_difference(chain(k, k + 1), Se2::from_vector(z.segment<3>(3 * Eigen::Index{k})));
    for (std::size_t l = 0; l < loops.size(); ++l) {
      const Eigen::Index at = n + static_cast<Eigen::Index>(3 * l);
      r.segment<3>(at) = additive_difference(chain(loops[l].to, loops[l].from), Se2::from_vector(z.segment<3>(at)));
    }
    return r;
  };
  const BatchSolution batch = solve_batch(z.head(n), residual, P);
  Eigen::VectorXd links(n);
  for (int k = 0; k < 20; ++k) links.segment<3>(3 * Eigen::Index{k}) = joiner.links().link(k).vector();
  EXPECT_LE(testing::difference_in_sigmas(links, batch.y, 20, batch.covariance), 0.01);
  EXPECT_LE(testing::covariance_difference(joiner.links().covariance(), batch.covariance), 0.002);
}

TEST(SelectiveThesisJoiner, T1_T2_TheChainVotesTwice) {
  // One loop between two maps. What is known of their relative pose is the chain, C, and the match, Z. The recipe puts the chain into the
  // fusion and the fused link on top of the chain: information C^-1 + (C^-1 + Z^-1) instead of C^-1 + Z^-1.
  Rng rng(542);
  const Laps laps(11);
  std::vector<Submap> submaps = laps.draw(0.0001, rng);
  RelativeMap chain;
  for (Submap& submap : submaps) {
    const LiveMap map = live_map_of(submap);
    chain.append({map.base_T_pose(0), map.covariance.topLeftCorner<3, 3>()});
    if (submap.index == 0 || submap.index == 10) continue;
    submap.landmarks.clear();  // a link only: one loop, between the first and the last
    submap.state.mean = submap.state.mean.head<3>().eval();
    submap.state.covariance = submap.state.covariance.topLeftCorner<3, 3>().eval();
  }
  LiveMap a = live_map_of(submaps[0]);
  LiveMap b = live_map_of(submaps[10]);
  remove_poses(a, {0});
  remove_poses(b, {0});
  const Fusion match = fuse(a, b, testing::pairs_by_identity(a, b));
  const Eigen::Matrix3d C = chain.relative(0, 10).covariance;
  const Eigen::Matrix3d Z = match.map.covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d once = (C.inverse() + Z.inverse()).inverse();
  const Eigen::Matrix3d thesis = (2.0 * C.inverse() + Z.inverse()).inverse();
  SelectiveThesisJoiner joiner({}, AssociationMethod::kKnown, 15, 1);
  int fusions = 0;
  for (const Submap& submap : submaps) fusions += joiner.take(submap).fusions;
  EXPECT_EQ(fusions, 1);
  EXPECT_EQ(joiner.maps().count(10), 0U);  // merged into map 0
  const Eigen::Matrix3d reported = joiner.links().relative(0, 10).covariance;
  EXPECT_LE(testing::covariance_difference(reported, thesis), 1e-3);
  EXPECT_GE(testing::covariance_difference(reported, once), 0.01);
}

TEST(RelativeJoiner, TheEstimateCoversEverything) {
  Rng rng(543);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.01, rng);
  for (const AssociationMethod method : {AssociationMethod::kKnown, AssociationMethod::kNearestNeighbour,
                                         AssociationMethod::kJointCompatibility, AssociationMethod::kRandomizedJointCompatibility}) {
    HierarchicalJoiner hierarchical({}, method, 15, 1);
    SelectiveThesisJoiner thesis({}, method, 15, 1);
    for (RelativeJoiner* const joiner : {static_cast<RelativeJoiner*>(&hierarchical), static_cast<RelativeJoiner*>(&thesis)}) {
      int accepted = 0, wrong = 0, fusions = 0;
      for (const Submap& submap : submaps) {
        const JoinReport report = joiner->take(submap);
        fusions += report.fusions;
        for (const LoopAttempt& loop : report.loops) {
          EXPECT_GT(loop.from - loop.to, 1);
          EXPECT_EQ(loop.accepted, loop.reason.empty());
          if (!loop.accepted) continue;
          ++accepted;
          wrong += loop.wrong_pairs.value_or(1000);
          EXPECT_GT(loop.dof, 0);
          EXPECT_GT(loop.sigma_m, 0.0);
        }
      }
      EXPECT_GE(accepted, 10);
      EXPECT_EQ(wrong, 0);
      EXPECT_EQ(fusions, joiner == &thesis ? accepted : 0);
      const WorldEstimate world = joiner->estimate(BaseCovariance::kJoint);
      ASSERT_EQ(world.global_T_base.size(), 21U);
      EXPECT_EQ(world.base_covariance.rows(), 63);
      EXPECT_EQ(world.global_T_base.back().vector(), joiner->global_T_newest_base().mean.vector());
      EXPECT_LE((world.base_covariance.bottomRightCorner<3, 3>() - joiner->global_T_newest_base().covariance).norm(), 1e-12);
      EXPECT_EQ(world.border_covariance[3], (world.base_covariance.block<6, 6>(9, 9)));
      std::set<std::int64_t> listed;
      int sightings = 0;
      for (const LandmarkEstimate& landmark : world.landmarks) {
        listed.insert(*landmark.landmark.source_id);
        sightings += landmark.landmark.times_seen;
        EXPECT_LE((landmark.position.mean - laps.world.landmarks.col(*landmark.landmark.source_id)).norm(), 0.2);
      }
      // Each once; without identities a landmark at the edge of a map may stand beside itself.
      EXPECT_LE(world.landmarks.size() - listed.size(), method == AssociationMethod::kKnown ? 0U : 2U);
      int expected = 0;
      for (const Submap& submap : submaps) expected += static_cast<int>(submap.landmarks.size());
      EXPECT_EQ(sightings, expected);
    }
  }
}

TEST(RelativeJoiner, RefusesWhatIsAmbiguousOrDoesNotFit) {
  Rng rng(544);
  const Laps laps(11);
  const std::vector<Submap> unsure = laps.draw(0.2, rng);
  const auto last_reason = [&](const std::vector<Submap>& submaps, double gate_m, AssociationMethod method) {
    SelectiveJoinerConfig config;
    config.max_pairing_sigma_m = gate_m;
    HierarchicalJoiner joiner(config, method, 15, 1);
    JoinReport report;
    for (const Submap& submap : submaps) report = joiner.take(submap);
    for (const LoopAttempt& loop : report.loops) {
      if (loop.to == 0) return loop.accepted ? std::string("accepted") : loop.reason;
    }
    return std::string("not compared");
  };
  EXPECT_EQ(last_reason(unsure, 0.3, AssociationMethod::kKnown), "accepted");  // identities cannot be ambiguous
  EXPECT_EQ(last_reason(unsure, 0.3, AssociationMethod::kJointCompatibility), "ambiguous: the maps' relative position is too unsure");
  std::vector<Submap> other = unsure;
  for (MapLandmark& landmark : other.back().landmarks) *landmark.source_id += 1000;
  EXPECT_EQ(last_reason(other, 0.3, AssociationMethod::kKnown), "too few landmarks in common");
  // The same shape, bent by ten sigma.
  std::vector<Submap> bent = unsure;
  const std::vector<Submap> good = laps.draw(0.01, rng);
  bent.front().state = good.front().state;
  bent.back().state = good.back().state;
  for (Eigen::Index i = 3; i < bent.back().state.mean.size(); i += 4) bent.back().state.mean(i) += 0.1;
  EXPECT_EQ(last_reason(bent, 20.0, AssociationMethod::kNearestNeighbour), "the maps do not fit on each other (chi-squared)");
}

}  // namespace
}  // namespace ssjs
