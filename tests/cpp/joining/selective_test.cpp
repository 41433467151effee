#include "ssjs/joining/selective.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>
#include <string>

#include "joining/gaussian_world.hpp"
#include "joining/laps.hpp"
#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/joining/conditional_map.hpp"

namespace ssjs {
namespace {

using testing::BatchSolution;
using testing::Laps;
using testing::noisy_submap;
using testing::solve_batch;
using testing::World;

constexpr int kMany = 1000;

SelectiveJoinerConfig keep_everything() {
  SelectiveJoinerConfig config;
  config.max_ports = kMany;
  config.max_inner_poses = kMany;
  config.final_adjustment = false;
  return config;
}

/// All submaps through a joiner.
struct Joined {
  Joined(const std::vector<Submap>& submaps, const SelectiveJoinerConfig& config, AssociationMethod method = AssociationMethod::kKnown)
      : joiner(config, method, 15, 1) {
    for (const Submap& submap : submaps) {
      const JoinReport report = joiner.take(submap);
      for (const LoopAttempt& loop : report.loops) {
        loops.push_back(loop);
        fusions += loop.accepted ? 1 : 0;
      }
    }
    joiner.finish();
    world = joiner.estimate(BaseCovariance::kJoint);
  }

  SelectiveJoiner joiner;
  std::vector<LoopAttempt> loops;
  WorldEstimate world;
  int fusions = 0;
};

/// Weighted least squares over all submaps at once: bases 1.. and the landmarks of every live map. What two maps share without having
/// been fused stays two landmarks, as it does in the joiner.
struct Batch {
  Batch(const std::vector<Submap>& submaps, const SelectiveJoiner& joiner, const std::vector<Se2>& start) {
    bases = static_cast<Eigen::Index>(submaps.size());
    std::map<int, int> map_of;  // submap -> base of its live map
    Eigen::Index size = 3 * bases;
    for (const auto& [base, map] : joiner.maps()) {
      for (const int member : map.members) map_of[member] = base;
      for (const MapLandmark& landmark : map.landmarks) {
        column[{base, *landmark.source_id}] = size;
        size += 2;
      }
    }
    Eigen::VectorXd y(size);
    for (Eigen::Index k = 1; k <= bases; ++k) y.segment<3>(3 * (k - 1)) = start[static_cast<std::size_t>(k)].vector();
    for (const Submap& submap : submaps) {
      for (std::size_t i = 0; i < submap.landmarks.size(); ++i) {
        y.segment<2>(column.at({map_of.at(submap.index), *submap.landmarks[i].source_id})) =
            start[static_cast<std::size_t>(submap.index)] * submap.state.landmark(static_cast<Eigen::Index>(i)).mean;
      }
    }

    Eigen::Index rows = 0;
    for (const Submap& submap : submaps) rows += submap.state.mean.size();
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
    rows = 0;
    for (const Submap& submap : submaps) {
      P.block(rows, rows, submap.state.mean.size(), submap.state.mean.size()) = submap.state.covariance;
      rows += submap.state.mean.size();
    }
    const auto residual = [&](const Eigen::VectorXd& x) {
      const auto pose = [&](int k) { return k == 0 ? Se2{} : Se2::from_vector(x.segment<3>(3 * (k - 1))); };
      Eigen::VectorXd r(P.rows());
      Eigen::Index row = 0;
      for (const Submap& submap : submaps) {
        const Se2 base_T_global = pose(submap.index).inverse();
        r.segment<3>(row) = additive_difference(base_T_global * pose(submap.index + 1), submap.state.vehicle().mean);
        for (std::size_t i = 0; i < submap.landmarks.size(); ++i) {
          const Eigen::Index at = column.at({map_of.at(submap.index), *submap.landmarks[i].source_id});
          r.segment<2>(row + 3 + static_cast<Eigen::Index>(2 * i)) =
              base_T_global * Eigen::Vector2d(x.segment<2>(at)) - submap.state.landmark(static_cast<Eigen::Index>(i)).mean;
        }
        row += submap.state.mean.size();
      }
      return r;
    };
    solution = solve_batch(y, residual, P);
  }

  Eigen::Index bases = 0;
  std::map<std::pair<int, std::int64_t>, Eigen::Index> column;
  BatchSolution solution;
};

/// Of standard deviations: the largest difference of a base and of a landmark; and the range of the ratios of standard deviations.
struct Agreement {
  double difference = 0.0, smallest_ratio = 1.0, largest_ratio = 1.0, joint = 0.0;
};
Agreement compare(const Joined& run, const Batch& batch) {
  const WorldEstimate& world = run.world;
  Agreement agreement;
  const Eigen::MatrixXd& P = batch.solution.covariance;
  const auto take = [&](double difference, double variance, Eigen::Index at) {
    const double ratio = std::sqrt(variance / P(at, at));
    agreement.difference = std::max(agreement.difference, std::abs(difference) / std::sqrt(P(at, at)));
    agreement.smallest_ratio = std::min(agreement.smallest_ratio, ratio);
    agreement.largest_ratio = std::max(agreement.largest_ratio, ratio);
    EXPECT_TRUE(std::isfinite(difference) && std::isfinite(ratio));
  };
  for (Eigen::Index k = 1; k <= batch.bases; ++k) {
    const Eigen::Vector3d difference =
        additive_difference(world.global_T_base[static_cast<std::size_t>(k)], Se2::from_vector(batch.solution.y.segment<3>(3 * (k - 1))));
    for (Eigen::Index c = 0; c < 3; ++c) take(difference(c), world.base_covariance(3 * k + c, 3 * k + c), 3 * (k - 1) + c);
    const auto of_border = world.base_covariance.block<6, 6>(3 * (k - 1), 3 * (k - 1));
    EXPECT_LE((world.border_covariance[static_cast<std::size_t>(k - 1)] - of_border).norm(), 1e-9 * of_border.norm());
  }
  for (const auto& [base, map] : run.joiner.maps()) {
    const WorldMap in_world = to_world(map, run.joiner.global());
    for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
      const Eigen::Index at = batch.column.at({base, *map.landmarks[i].source_id});
      const Eigen::Vector2d difference = in_world.landmarks.col(static_cast<Eigen::Index>(i)) - batch.solution.y.segment<2>(at);
      for (Eigen::Index c = 0; c < 2; ++c) take(difference(c), in_world.landmark_covariance[i](c, c), at + c);
    }
  }
  const Eigen::Index n = 3 * batch.bases;
  agreement.joint = testing::covariance_difference(world.base_covariance.bottomRightCorner(n, n), P.topLeftCorner(n, n));
  return agreement;
}

TEST(SelectiveJoiner, J1_J17_EveryMeasurementCountsOnce) {
  // Against the batch solution of all submaps, in a world small enough to be linear: after a dozen fusions and re-fusions neither the
  // estimate nor its covariance has drifted off.
  Rng rng(472);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.001, rng);
  for (const GlobalSolver solver : {GlobalSolver::kInvariantEkf, GlobalSolver::kGaussNewton}) {
    SelectiveJoinerConfig config = keep_everything();
    config.solver = solver;
    config.fusion_threshold = 0.1;  // maps of several neighbours as well
    const Joined run(submaps, config);
    EXPECT_GE(run.fusions, 12);
    EXPECT_LE(run.world.maps.size(), 6U);
    const Agreement agreement = compare(run, Batch(submaps, run.joiner, run.world.global_T_base));
    EXPECT_LE(agreement.difference, 0.01);
    EXPECT_GE(agreement.smallest_ratio, 0.999);
    EXPECT_LE(agreement.largest_ratio, 1.001);
    EXPECT_LE(agreement.joint, 2e-3);
  }
}

TEST(SelectiveJoiner, J19_FewerSharedBasesLoseInformationAndInventNone) {
  Rng rng(473);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.001, rng);
  for (const GlobalSolver solver : {GlobalSolver::kInvariantEkf, GlobalSolver::kGaussNewton}) {
    SelectiveJoinerConfig config = keep_everything();
    config.max_ports = 2;
    config.solver = solver;
    config.fusion_threshold = 0.1;
    const Joined run(submaps, config);
    const Agreement agreement = compare(run, Batch(submaps, run.joiner, run.world.global_T_base));
    // The factors forget what they no longer hold. The chained filter has used it already, and takes what hangs on it for independent.
    EXPECT_GE(agreement.smallest_ratio, solver == GlobalSolver::kGaussNewton ? 0.999 : 0.98);
    const std::string name = solver == GlobalSolver::kGaussNewton ? "gauss_newton" : "ekf";
    RecordProperty(name + "_smallest_ratio", std::to_string(agreement.smallest_ratio));
    RecordProperty(name + "_largest_ratio", std::to_string(agreement.largest_ratio));
  }
}

TEST(SelectiveJoiner, J18_FrozenBasesStayConsistent) {
  // No inner pose is kept: every one of them leaves its map with what was known then. Their normalised errors over many missions.
  constexpr int kRuns = 60;
  const Laps laps(20);
  SelectiveJoinerConfig config;  // with the last adjustment, as in a mission
  config.max_inner_poses = 0;
  config.fusion_threshold = 0.1;
  Rng rng(474);
  double nees = 0.0;
  int count = 0;
  for (int i = 0; i < kRuns; ++i) {
    const std::vector<Submap> submaps = laps.draw(0.01, rng);
    const Joined run(submaps, config);
    std::set<int> held;
    for (const auto& [base, map] : run.joiner.maps()) {
      held.insert(base);
      held.insert(map.poses.begin(), map.poses.end());
    }
    for (int k = 1; k <= 20; ++k) {
      if (held.count(k) != 0) continue;
      const Eigen::Vector3d error =
          additive_difference(run.world.global_T_base[static_cast<std::size_t>(k)], laps.world.global_T_base[static_cast<std::size_t>(k)]);
      nees += normalized_squared_error(error, run.world.base_covariance.block<3, 3>(3 * k, 3 * k));
      ++count;
    }
    const Eigen::VectorXd eigenvalues = run.world.base_covariance.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GE(eigenvalues.minCoeff(), -1e-12);
  }
  ASSERT_GT(count, 100);
  RecordProperty("frozen_base_nees", std::to_string(nees / count));
  EXPECT_GE(nees / count, 2.0);
  EXPECT_LE(nees / count, 3.6);
}

TEST(SelectiveJoiner, FindsTheSamePairsWithoutIdentities) {
  Rng rng(475);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.01, rng);
  const Joined known(submaps, keep_everything());
  for (const AssociationMethod method : {AssociationMethod::kJointCompatibility, AssociationMethod::kRandomizedJointCompatibility}) {
    const Joined unknown(submaps, keep_everything(), method);
    EXPECT_GE(unknown.fusions, 8);
    int wrong = 0;
    for (const LoopAttempt& loop : unknown.loops) wrong += loop.wrong_pairs.value_or(0);
    EXPECT_EQ(wrong, 0);
  }
  for (const LoopAttempt& loop : known.loops) {
    if (!loop.accepted) continue;
    EXPECT_TRUE(loop.reason.empty());
    EXPECT_EQ(loop.wrong_pairs, 0);
    EXPECT_GE(loop.pairs, 3);
    EXPECT_GT(loop.dof, 0);
    EXPECT_TRUE(loop.chi_squared.has_value());
    EXPECT_GT(loop.sigma_m, 0.0);
    EXPECT_EQ(loop.time_s, loop.from + 1.0);
  }
}

TEST(SelectiveJoiner, NeighboursInTimeAreNotCompared) {
  Rng rng(476);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.01, rng);
  for (const int gap : {1, 4}) {
    SelectiveJoinerConfig config = keep_everything();
    config.min_gap = gap;
    const Joined run(submaps, config);
    EXPECT_GT(run.loops.size(), 0U);
    for (const LoopAttempt& loop : run.loops) EXPECT_GT(loop.from - loop.to, gap);
  }
}

TEST(SelectiveJoiner, TheEstimateCoversEverything) {
  Rng rng(477);
  const Laps laps(14);
  const std::vector<Submap> submaps = laps.draw(0.01, rng);
  SelectiveJoinerConfig config = keep_everything();
  SelectiveJoiner joiner(config, AssociationMethod::kKnown, 15, 1);
  for (const Submap& submap : submaps) {
    (void)joiner.take(submap);
    const GaussianSe2 newest = joiner.global_T_newest_base();
    const WorldEstimate world = joiner.estimate(BaseCovariance::kJoint);
    ASSERT_EQ(world.global_T_base.size(), static_cast<std::size_t>(submap.index) + 2);
    EXPECT_EQ(world.global_T_base.back().vector(), newest.mean.vector());
    EXPECT_LE((world.base_covariance.bottomRightCorner<3, 3>() - newest.covariance).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_EQ(world.base_covariance.topRows<3>().cwiseAbs().maxCoeff(), 0.0);
    std::multiset<int> members;
    for (const LiveMapEstimate& map : world.maps) members.insert(map.members.begin(), map.members.end());
    EXPECT_EQ(members.size(), static_cast<std::size_t>(submap.index) + 1);  // each submap in exactly one live map
    EXPECT_EQ(std::set<int>(members.begin(), members.end()).size(), members.size());
    // What stands in several maps is listed once, with all its sightings.
    std::set<int> seen;
    int sightings = 0;
    for (int k = 0; k <= submap.index; ++k) {
      seen.insert(laps.seen[static_cast<std::size_t>(k)].begin(), laps.seen[static_cast<std::size_t>(k)].end());
      sightings += static_cast<int>(laps.seen[static_cast<std::size_t>(k)].size());
    }
    EXPECT_EQ(world.landmarks.size(), seen.size());
    for (const LandmarkEstimate& landmark : world.landmarks) sightings -= landmark.landmark.times_seen;
    EXPECT_EQ(sightings, 0);
  }
  // Every landmark is where it should be, by its own covariance.
  for (const LandmarkEstimate& landmark : joiner.estimate(BaseCovariance::kJoint).landmarks) {
    const Eigen::Vector2d error = landmark.position.mean - laps.world.landmarks.col(*landmark.landmark.source_id);
    EXPECT_LE(normalized_squared_error(error, landmark.position.covariance), 36.0);
  }
}

TEST(SelectiveJoiner, FinalAdjustmentIsTheBatchOverThePortFactors) {
  Rng rng(478);
  const Laps laps(20);
  const std::vector<Submap> submaps = laps.draw(0.05, rng);
  SelectiveJoinerConfig config = keep_everything();
  config.final_adjustment = true;
  const Joined adjusted(submaps, config);
  config.solver = GlobalSolver::kGaussNewton;
  const Joined batch(submaps, config);
  EXPECT_TRUE(adjusted.joiner.global().is_sparse());
  for (std::size_t k = 1; k <= 20; ++k) {
    EXPECT_LE(additive_difference(adjusted.world.global_T_base[k], batch.world.global_T_base[k]).norm(), 0.01) << k;
  }
}

/// What a joiner says about the last of these submaps.
std::vector<LoopAttempt> last_attempts(const std::vector<Submap>& submaps, const SelectiveJoinerConfig& config, AssociationMethod method) {
  SelectiveJoiner joiner(config, method, 15, 1);
  JoinReport report;
  for (const Submap& submap : submaps) report = joiner.take(submap);
  return report.loops;
}

/// Neighbours on the ring share less than this, so that the last of eleven submaps meets the first and no other.
SelectiveJoinerConfig only_the_ends_meet() {
  SelectiveJoinerConfig config;
  config.fusion_threshold = 0.4;
  return config;
}

TEST(SelectiveJoiner, SaysWhyMapsWereNotFused) {
  Rng rng(479);
  const Laps laps(11);  // submap 10 comes back to submap 0
  const auto jcbb = AssociationMethod::kJointCompatibility;
  const auto reason_of = [](const std::vector<LoopAttempt>& loops, int to) {
    for (const LoopAttempt& loop : loops) {
      if (loop.to == to) return loop.accepted ? std::string("accepted") : loop.reason;
    }
    return std::string("not compared");
  };
  const std::vector<Submap> good = laps.draw(0.01, rng);
  EXPECT_EQ(reason_of(last_attempts(good, only_the_ends_meet(), jcbb), 0), "accepted");
  EXPECT_EQ(reason_of(last_attempts(good, only_the_ends_meet(), jcbb), 5), "not compared");  // the other side of the ring
  EXPECT_EQ(reason_of(last_attempts(good, only_the_ends_meet(), jcbb), 9), "not compared");  // its neighbour

  SelectiveJoinerConfig config = only_the_ends_meet();
  config.max_fused_landmarks = static_cast<int>(laps.seen[0].size()) - 1;
  EXPECT_EQ(reason_of(last_attempts(good, config, jcbb), 0), "the fused map would be too large");

  config = only_the_ends_meet();
  config.min_pairs = static_cast<int>(laps.seen[0].size()) + 1;
  EXPECT_TRUE(last_attempts(good, config, jcbb).empty());  // cannot share so many, whatever is there

  std::vector<Submap> poor = good;  // the last map sees other landmarks at other places, though in the same area
  for (std::size_t i = 0; i < poor.back().landmarks.size(); ++i) {
    poor.back().state.mean.segment<2>(3 + static_cast<Eigen::Index>(2 * i)) += Eigen::Vector2d(0.7 - 0.2 * static_cast<double>(i), 0.9);
    poor.back().landmarks[i].source_id = 1000 + static_cast<std::int64_t>(i);
  }
  EXPECT_EQ(reason_of(last_attempts(poor, only_the_ends_meet(), jcbb), 0), "too few landmarks in common");
  EXPECT_EQ(reason_of(last_attempts(poor, only_the_ends_meet(), AssociationMethod::kKnown), 0), "too few landmarks in common");

  // Ten links of 0.2 m and 0.02 rad leave about a metre open; the gate asks for less, then for much less.
  const std::vector<Submap> unsure = laps.draw(0.2, rng);
  const std::vector<LoopAttempt> open = last_attempts(unsure, only_the_ends_meet(), AssociationMethod::kKnown);
  ASSERT_EQ(reason_of(open, 0), "accepted");
  double sigma_m = 0.0;
  for (const LoopAttempt& loop : open) {
    if (loop.to == 0) sigma_m = loop.sigma_m;
  }
  config = only_the_ends_meet();
  config.max_pairing_sigma_m = 0.9 * sigma_m;
  EXPECT_EQ(reason_of(last_attempts(unsure, config, AssociationMethod::kKnown), 0), "accepted");  // identities cannot be ambiguous
  EXPECT_EQ(reason_of(last_attempts(unsure, config, jcbb), 0), "ambiguous: the paired landmarks' relative position is too unsure");
  config.max_pairing_sigma_m = 0.3 * sigma_m;
  EXPECT_EQ(reason_of(last_attempts(unsure, config, jcbb), 0), "ambiguous: the maps' relative position is too unsure");

  // The same shape, bent by ten sigma: every pair is compatible with the loose links, the maps are not with each other.
  std::vector<Submap> bent = unsure;
  const Eigen::MatrixXd tight = good.back().state.covariance;
  for (Submap* const submap : {&bent.front(), &bent.back()}) {
    const Submap& precise = submap == &bent.front() ? good.front() : good.back();
    submap->state = precise.state;
  }
  for (Eigen::Index i = 3; i < bent.back().state.mean.size(); i += 4) bent.back().state.mean(i) += 0.1;
  EXPECT_EQ(reason_of(last_attempts(bent, only_the_ends_meet(), AssociationMethod::kNearestNeighbour), 0),
            "the maps do not fit on each other (chi-squared)");
}

TEST(SelectiveJoiner, TooFewLandmarksNearEachOtherAreNotSearched) {
  // Two maps whose circles touch, with their landmarks at the far ends.
  World world{{{}, {1.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}, Eigen::Matrix2Xd(2, 8)};
  world.landmarks << 0.0, 0.1, 0.2, 0.3, 10.0, 10.1, 10.2, 10.3,  //
      5.0, -5.0, 4.0, -4.0, 5.0, -5.0, 4.0, -4.0;
  Rng rng(480);
  const std::vector<Submap> submaps{noisy_submap(world, 0, {0, 1, 2, 3}, 0.01, rng), noisy_submap(world, 1, {}, 0.01, rng),
                                    noisy_submap(world, 2, {4, 5, 6, 7}, 0.01, rng)};
  const std::vector<LoopAttempt> loops = last_attempts(submaps, {}, AssociationMethod::kJointCompatibility);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].reason, "too few landmarks near each other");
}

TEST(SelectiveJoiner, WrongIdentitiesAreCounted) {
  Rng rng(481);
  const Laps laps(11);
  std::vector<Submap> submaps = laps.draw(0.01, rng);
  std::swap(submaps.back().landmarks[0].source_id, submaps.back().landmarks[1].source_id);
  const std::vector<LoopAttempt> loops = last_attempts(submaps, only_the_ends_meet(), AssociationMethod::kJointCompatibility);
  int wrong = 0;
  for (const LoopAttempt& loop : loops) {
    if (loop.to == 0) wrong = loop.wrong_pairs.value_or(-1);
  }
  EXPECT_EQ(wrong, 2);
  submaps.back().landmarks[0].source_id.reset();  // not all are known: nothing can be said
  for (const LoopAttempt& loop : last_attempts(submaps, only_the_ends_meet(), AssociationMethod::kJointCompatibility)) {
    EXPECT_TRUE(loop.to != 0 || !loop.wrong_pairs);
  }
}

}  // namespace
}  // namespace ssjs
