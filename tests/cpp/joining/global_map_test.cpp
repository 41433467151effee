#include "ssjs/joining/global_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/fusion.hpp"
#include "ssjs/joining/loop_candidates.hpp"

namespace ssjs {
namespace {

using testing::covariance_difference;
using testing::noisy_submap;
using testing::numeric_jacobian;
using testing::random_map;
using testing::World;

constexpr int kNeverSparse = 1000;
constexpr double kEverywhere = 1e6;  // reach, m

Encounter encounter_within(const LiveMap& a, const LiveMap& b, const GlobalMap& global, double reach_m) {
  return encounter(a, b, global, overlap(a, b, global, reach_m));
}

World ring(int bases) {
  World world{{Se2{}}, Eigen::Matrix2Xd(2, 12)};
  for (int k = 1; k < bases; ++k) world.global_T_base.push_back(world.global_T_base.back() * Se2{6.0, 0.5, 0.9});
  Rng rng(451);
  for (Eigen::Index i = 0; i < 12; ++i) world.landmarks.col(i) << rng.uniform(-8.0, 8.0), rng.uniform(0.0, 14.0);
  return world;
}

std::vector<LiveMap> chain(const World& world, double sigma_m, Rng& rng, const std::vector<int>& landmarks = {}) {
  std::vector<LiveMap> maps;
  for (int k = 0; k + 1 < static_cast<int>(world.global_T_base.size()); ++k)
    maps.push_back(live_map_of(noisy_submap(world, k, landmarks, sigma_m, rng)));
  return maps;
}

std::vector<int> sorted(std::vector<int> v) {
  std::sort(v.begin(), v.end());
  return v;
}

TEST(GlobalMap, J5_AChainOfSubmapsCarriesItsErrorsOn) {
  Rng rng(452);
  const World world = ring(6);
  const std::vector<LiveMap> maps = chain(world, 0.1, rng);
  GlobalMap global(GlobalSolver::kInvariantEkf, kNeverSparse);
  for (const LiveMap& map : maps) global.attach(map);
  // X_k as a function of all links, which are independent of each other
  Eigen::VectorXd links(15);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(15, 15);
  for (Eigen::Index k = 0; k < 5; ++k) {
    links.segment<3>(3 * k) = maps[static_cast<std::size_t>(k)].mean.head<3>();
    P.block<3, 3>(3 * k, 3 * k) = maps[static_cast<std::size_t>(k)].covariance.topLeftCorner<3, 3>();
  }
  const auto bases = [](const Eigen::VectorXd& t) {
    Eigen::VectorXd x(t.size());
    Se2 pose;
    for (Eigen::Index k = 0; k < t.size(); k += 3) {
      pose = pose * Se2::from_vector(t.segment<3>(k));
      x.segment<3>(k) = pose.vector();
    }
    return x;
  };
  const Eigen::VectorXd x = bases(links);
  const Eigen::MatrixXd J = numeric_jacobian(bases, links, {2, 5, 8, 11, 14});
  for (Eigen::Index k = 0; k < 5; ++k) {
    EXPECT_LE(additive_difference(global.pose(static_cast<int>(k) + 1), Se2::from_vector(x.segment<3>(3 * k))).norm(), 1e-12);
  }
  EXPECT_LE(covariance_difference(global.covariance({1, 2, 3, 4, 5}), J * P * J.transpose()), 1e-7);
  const Eigen::MatrixXd with_world = global.covariance({3, 0});
  EXPECT_EQ(with_world.rightCols<3>().cwiseAbs().maxCoeff(), 0.0);  // base 0 is the world: known
  EXPECT_EQ(global.bases(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

/// Random evidence on three of the bases.
JoinEvidence random_evidence(Rng& rng, const std::vector<int>& bases) {
  const auto columns = static_cast<Eigen::Index>(3 * bases.size());
  JoinEvidence evidence{bases, testing::normal_vector(rng, 6), Eigen::MatrixXd(6, columns),
                        testing::correlated_covariance(rng, Eigen::VectorXd::Constant(6, 0.5))};
  for (Eigen::Index c = 0; c < columns; ++c) evidence.J.col(c) = testing::normal_vector(rng, 6);
  return evidence;
}

TEST(GlobalMap, J14_J15_UpdateEqualsTheTextbookInvariantFilter) {
  Rng rng(453);
  for (int trial = 0; trial < 10; ++trial) {
    const World world = ring(7);
    const std::vector<LiveMap> maps = chain(world, 0.3, rng);
    GlobalMap global(GlobalSolver::kInvariantEkf, kNeverSparse);
    for (const LiveMap& map : maps) global.attach(map);
    const std::vector<int> all{1, 2, 3, 4, 5, 6};
    std::vector<Se2> X;
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(18, 18);
    for (int k = 1; k <= 6; ++k) {
      X.push_back(global.pose(k));
      M.block<3, 3>(3 * (k - 1), 3 * (k - 1)) = invariant_frame(global.pose(k));
    }
    const Eigen::MatrixXd P_xi = M.inverse() * global.covariance(all) * M.inverse().transpose();

    // base 0 may be involved as well: it does not move
    const JoinEvidence evidence = random_evidence(rng, {5, 2, 0, 3});
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6, 18);
    H.middleCols<3>(12) = evidence.J.middleCols<3>(0);
    H.middleCols<3>(3) = evidence.J.middleCols<3>(3);
    H.middleCols<3>(6) = evidence.J.middleCols<3>(9);
    const Eigen::MatrixXd H_xi = H * M;
    const Eigen::MatrixXd K = P_xi * H_xi.transpose() * (H_xi * P_xi * H_xi.transpose() + evidence.noise).inverse();
    const Eigen::VectorXd xi = -K * evidence.residual;
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(18, 18) - K * H_xi;
    const Eigen::MatrixXd P_xi_new = A * P_xi * A.transpose() + K * evidence.noise * K.transpose();  // Joseph form
    for (Eigen::Index k = 0; k < 6; ++k) {
      Se2& pose = X[static_cast<std::size_t>(k)];
      pose = se2_exp(xi.segment<3>(3 * k)) * pose;
      M.block<3, 3>(3 * k, 3 * k) = invariant_frame(pose);
    }

    // The map of bases 2 and 4 keeps every base it knew as a port, so that all stay live.
    const LiveMap joined = random_map(rng, 2, {3, 4, 5}, 3, 0, 0.3);
    global.replace(2, 4, joined, evidence, {});
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Eigen::Vector3d difference = additive_difference(global.pose(static_cast<int>(k) + 1), X[static_cast<std::size_t>(k)]);
      EXPECT_LE(difference.norm(), 1e-9) << "base " << k + 1;
    }
    EXPECT_LE(covariance_difference(global.covariance(all), M * P_xi_new * M.transpose()), 1e-9);
    EXPECT_EQ(global.pose(0).vector(), Eigen::Vector3d::Zero());
  }
}

TEST(GlobalMap, UnusedBasesAreMarginalisedOut) {
  Rng rng(454);
  const World world = ring(8);
  const std::vector<LiveMap> maps = chain(world, 0.1, rng);
  GlobalMap kept(GlobalSolver::kInvariantEkf, kNeverSparse);
  GlobalMap forgetful(GlobalSolver::kInvariantEkf, kNeverSparse);
  for (GlobalMap* const global : {&kept, &forgetful}) {
    for (const LiveMap& map : maps) global->attach(map);
  }
  const JoinEvidence evidence = random_evidence(rng, {2, 3, 4});
  kept.replace(2, 3, random_map(rng, 2, {3, 4}, 2, 0, 0.1), evidence, {});
  LiveMap joined = random_map(rng, 2, {4, 3}, 1, 0, 0.1);  // base 3 is inside now
  forgetful.replace(2, 3, joined, evidence, {});
  EXPECT_EQ(sorted(forgetful.bases()), (std::vector<int>{0, 1, 2, 4, 5, 6, 7}));
  const std::vector<int> rest{1, 2, 4, 5, 6, 7};
  EXPECT_EQ(forgetful.covariance(rest), kept.covariance(rest));
  EXPECT_EQ(forgetful.pose(3).vector(), kept.pose(3).vector());  // its last estimate
  try {
    (void)forgetful.covariance({1, 3});
    FAIL() << "a forgotten base has no covariance";
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(std::string(error.what()), "base = 3: is not a live base of the global map");
  }
  // The next base attaches to what is left as if nothing had happened.
  Rng tail(455);
  const LiveMap next = random_map(tail, 7, {8}, 1, 0, 0.1);
  kept.attach(next);
  forgetful.attach(next);
  EXPECT_EQ(forgetful.covariance({8, 2, 5}), kept.covariance({8, 2, 5}));
}

TEST(GlobalMap, J5_J16_DenseAndSparseAgreeOnAChain) {
  Rng rng(456);
  const World world = ring(9);
  const std::vector<LiveMap> maps = chain(world, 0.1, rng);
  GlobalMap dense(GlobalSolver::kInvariantEkf, kNeverSparse);
  GlobalMap sparse(GlobalSolver::kGaussNewton, kNeverSparse);
  for (const LiveMap& map : maps) {
    dense.attach(map);
    sparse.attach(map);
    const std::vector<int> bases = dense.bases();
    const Eigen::Index n = 3 * map.base + 3;  // without base 0
    EXPECT_LE(covariance_difference(sparse.covariance(bases).bottomRightCorner(n, n), dense.covariance(bases).bottomRightCorner(n, n)),
              1e-9);
    EXPECT_EQ(sparse.pose(map.base + 1).vector(), dense.pose(map.base + 1).vector());
  }
  EXPECT_FALSE(dense.is_sparse());
  EXPECT_TRUE(sparse.is_sparse());
}

TEST(GlobalMap, J16_TheCheaperWayIsTakenAndBothAgree) {
  // A long chain is cheap to factorise; one map that ties all of its bases together is not.
  constexpr int kBases = 130;
  Rng rng(463);
  World world{{Se2{}}, Eigen::Matrix2Xd(2, 12)};
  for (int k = 1; k < kBases; ++k) world.global_T_base.push_back(world.global_T_base.back() * Se2{6.0, 0.5, 0.02});
  const std::vector<LiveMap> maps = chain(world, 0.01, rng);
  GlobalMap switching(GlobalSolver::kInvariantEkf, 5);
  GlobalMap sparse(GlobalSolver::kGaussNewton, 5);
  for (const LiveMap& map : maps) {
    switching.attach(map);
    sparse.attach(map);
    EXPECT_TRUE(map.base > 20 || !switching.is_sparse());
  }
  EXPECT_TRUE(switching.is_sparse());

  std::vector<int> all;
  for (int base = 3; base < 100; ++base) all.push_back(base);
  LiveMap knot = random_map(rng, 2, all, static_cast<Eigen::Index>(all.size()), 0, 1.0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    knot.mean.segment<3>(static_cast<Eigen::Index>(3 * i)) = (switching.pose(2).inverse() * switching.pose(all[i])).vector();
  }
  const JoinEvidence unused{{}, {}, {}, {}};  // the factors say it all
  switching.replace(2, 3, knot, unused, {});
  sparse.replace(2, 3, knot, unused, {});
  switching.settle();
  sparse.settle();
  EXPECT_FALSE(switching.is_sparse());
  std::vector<int> known = switching.bases();
  known.erase(std::remove(known.begin(), known.end(), 0), known.end());
  EXPECT_LE(covariance_difference(switching.covariance(known), sparse.covariance(known)), 1e-9);
  // and goes on as a filter does
  const LiveMap next = random_map(rng, kBases - 1, {kBases}, 1, 0, 0.1);
  switching.attach(next);
  sparse.attach(next);
  EXPECT_LE(covariance_difference(switching.covariance({kBases, 50}), sparse.covariance({kBases, 50})), 1e-9);
}

/// A loop: eight links around, and the first and the last map see the same landmarks.
struct Loop {
  World world = ring(9);
  std::vector<LiveMap> maps;
  LiveMap joined;

  Loop(Rng& rng, double sigma_m) {
    for (int k = 0; k < 8; ++k) {
      const std::vector<int> landmarks = k == 1 || k == 6 ? std::vector<int>{0, 1, 2, 3, 4, 5} : std::vector<int>{};
      maps.push_back(live_map_of(noisy_submap(world, k, landmarks, sigma_m, rng)));
    }
    joined = fuse(maps[1], maps[6], testing::pairs_by_identity(maps[1], maps[6])).map;
    set_ports(joined, {true, true, true});  // bases 2, 6, 7
  }
  void close(GlobalMap& global) const {
    for (const LiveMap& map : maps) global.attach(map);
    const Encounter meeting = encounter_within(maps[1], maps[6], global, kEverywhere);
    global.replace(1, 6, joined, evidence_of(meeting, testing::pairs_by_identity(maps[1], maps[6])), {});
    global.settle();
  }
};

TEST(GlobalMap, J14_J16_DenseAndSparseAgreeOnALoopWithTinyNoise) {
  // One update against Gauss-Newton: they differ by what is quadratic in 1 mm and 0.1 mrad.
  Rng rng(457);
  const Loop loop(rng, 0.001);
  GlobalMap dense(GlobalSolver::kInvariantEkf, kNeverSparse);
  GlobalMap switching(GlobalSolver::kInvariantEkf, 5);
  GlobalMap sparse(GlobalSolver::kGaussNewton, kNeverSparse);
  const std::vector<int> all{1, 2, 3, 4, 5, 6, 7, 8};
  loop.close(dense);
  loop.close(switching);
  loop.close(sparse);
  const Eigen::MatrixXd P = sparse.covariance(all);
  for (const GlobalMap* const global : {&dense, &switching}) {
    EXPECT_LE(covariance_difference(global->covariance(all), P), 2e-3);
    for (const int k : all) {
      const Eigen::Vector3d sigmas = P.diagonal().segment<3>(3 * (k - 1)).cwiseSqrt();
      const Eigen::Vector3d difference = additive_difference(global->pose(k), sparse.pose(k));
      EXPECT_LE((difference.array() / sigmas.array()).abs().maxCoeff(), 2e-3);
    }
  }
}

TEST(GlobalMap, J16_RelinearisingADenseMapGivesTheSparseAnswer) {
  Rng rng(458);
  const Loop loop(rng, 0.2);
  GlobalMap dense(GlobalSolver::kInvariantEkf, kNeverSparse);
  GlobalMap sparse(GlobalSolver::kGaussNewton, kNeverSparse);
  loop.close(dense);
  loop.close(sparse);
  dense.relinearize();
  sparse.relinearize();
  EXPECT_TRUE(dense.is_sparse());
  const std::vector<int> all{1, 2, 3, 4, 5, 6, 7, 8};
  for (const int k : all) EXPECT_LE(additive_difference(dense.pose(k), sparse.pose(k)).norm(), 1e-5);
  EXPECT_LE(covariance_difference(dense.covariance(all), sparse.covariance(all)), 1e-4);
}

TEST(GlobalMap, J5_ANewChainBehindASparseLoopNeedsNoFactorisation) {
  // Bases attached behind the last factorisation: the same covariances as when everything is factorised anew.
  Rng rng(459);
  const Loop loop(rng, 0.05);
  GlobalMap tailed(GlobalSolver::kGaussNewton, kNeverSparse);
  loop.close(tailed);
  (void)tailed.covariance({1, 8});
  GlobalMap fresh = GlobalMap(GlobalSolver::kGaussNewton, kNeverSparse);
  loop.close(fresh);
  for (int k = 8; k < 12; ++k) {
    const LiveMap next = random_map(rng, k, {k + 1}, 1, 0, 0.05);
    tailed.attach(next);
    fresh.attach(next);
  }
  fresh.relinearize();  // the chain adds no residual: the solution stays, its factorisation is new
  const std::vector<int> some{12, 3, 10, 8, 0, 11};
  Eigen::MatrixXd expected = fresh.covariance(some);
  Eigen::MatrixXd answer = tailed.covariance(some);
  EXPECT_EQ(answer.middleRows<3>(12).cwiseAbs().maxCoeff(), 0.0);
  for (Eigen::MatrixXd* const P : {&expected, &answer}) P->diagonal().segment<3>(12).setOnes();  // base 0, for the comparison
  EXPECT_LE(covariance_difference(answer, expected), 1e-6);
  EXPECT_LE((answer - answer.transpose()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(GlobalMap, BoundForDismissingFarMapsIsNeverTooSmall) {
  Rng rng(460);
  const Loop loop(rng, 0.02);
  for (const GlobalSolver solver : {GlobalSolver::kInvariantEkf, GlobalSolver::kGaussNewton}) {
    GlobalMap global(solver, kNeverSparse);
    for (const LiveMap& map : loop.maps) {
      global.attach(map);
      (void)global.covariance_bound(map.base, map.base + 1);  // remembered from here on
    }
    const Encounter meeting = encounter_within(loop.maps[1], loop.maps[6], global, kEverywhere);
    global.replace(1, 6, loop.joined, evidence_of(meeting, testing::pairs_by_identity(loop.maps[1], loop.maps[6])), {});
    global.settle();
    for (const int base : {2, 4, 6}) {
      const Eigen::MatrixXd truth = global.covariance({base, 8});
      const Eigen::MatrixXd bound = global.covariance_bound(base, 8);
      const Eigen::MatrixXd excess = bound.topLeftCorner<3, 3>() - truth.topLeftCorner<3, 3>();
      EXPECT_GE(excess.diagonal().minCoeff(), -1e-3 * truth.diagonal().head<3>().maxCoeff());
      EXPECT_LE((bound.bottomRightCorner<3, 3>() - truth.bottomRightCorner<3, 3>()).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(GlobalMap, NotPositiveDefiniteIsNamed) {
  Rng rng(461);
  const World world = ring(5);
  GlobalMap global(GlobalSolver::kInvariantEkf, kNeverSparse);
  for (const LiveMap& map : chain(world, 0.1, rng)) global.attach(map);
  const Eigen::MatrixXd before = global.covariance({1, 2, 3, 4});
  JoinEvidence evidence = random_evidence(rng, {1, 3});
  evidence.noise = -100.0 * Eigen::MatrixXd::Identity(6, 6);
  try {
    global.replace(1, 3, random_map(rng, 1, {2, 3, 4}, 3, 0, 0.1), evidence, {});
    FAIL() << "a negative noise was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(std::string(error.what()), "innovation covariance of the bases is not positive definite (map-to-map pairing)");
  }
  EXPECT_EQ(global.covariance({1, 2, 3, 4}), before);
  LiveMap broken = random_map(rng, 4, {5}, 1, 0, 0.1);
  broken.covariance(0, 0) = -1.0;
  try {
    set_ports(broken, {true});  // where the port factor is made
    FAIL() << "a negative variance was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(std::string(error.what()), "port covariance is not positive definite (map at base 4)");
  }
}

}  // namespace
}  // namespace ssjs
