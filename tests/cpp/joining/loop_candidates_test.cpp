#include "ssjs/joining/loop_candidates.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

using testing::global_map_at;
using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_map;
using testing::random_pose;

constexpr double kEverywhere = 1e6;  // reach, m

/// Two maps that share base 3: a at base 1 with ports 2 and 3, b at base 4 with ports 3 and 5 and the internal pose 6. None of the
/// bases stands where the maps think.
struct Meeting {
  std::vector<Se2> bases;  ///< 1 to 5
  LiveMap a, b;

  explicit Meeting(Rng& rng, int point) {
    for (int k = 0; k < 5; ++k) bases.push_back(random_pose(rng, point + k));
    a = random_map(rng, 1, {2, 3}, 2, 4, 0.3);
    b = random_map(rng, 4, {3, 5, 6}, 2, 5, 0.3);
    for (LiveMap* map : {&a, &b}) {
      for (Eigen::Index i = 0; i < map->ports; ++i) {
        const Se2 truth = base(map->base).inverse() * base(map->poses[static_cast<std::size_t>(i)]);
        map->mean.segment<3>(3 * i) = additive_step(truth, Eigen::Vector3d(rng.normal(0.3), rng.normal(0.3), rng.normal(0.2))).vector();
      }
    }
  }
  [[nodiscard]] const Se2& base(int k) const { return bases[static_cast<std::size_t>(k) - 1]; }
};

/// The coordinates of the listed bases, and a global map with them moved to x.
Eigen::VectorXd coordinates(const Meeting& meeting, const std::vector<int>& bases) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(3 * bases.size()));
  for (std::size_t i = 0; i < bases.size(); ++i) x.segment<3>(static_cast<Eigen::Index>(3 * i)) = meeting.base(bases[i]).vector();
  return x;
}
GlobalMap moved(const Meeting& meeting, const std::vector<int>& bases, const Eigen::VectorXd& x) {
  std::vector<Se2> poses = meeting.bases;
  for (std::size_t i = 0; i < bases.size(); ++i) {
    poses[static_cast<std::size_t>(bases[i]) - 1] = Se2::from_vector(x.segment<3>(static_cast<Eigen::Index>(3 * i)));
  }
  return global_map_at(poses);
}

TEST(LoopCandidates, J7_JacobiansOfBothMapsInOneFrame) {
  Rng rng(431);
  for (int i = 0; i < kJacobianPoints; ++i) {
    const Meeting point(rng, i);
    const Encounter meeting = encounter(point.a, point.b, global_map_at(point.bases), kEverywhere);
    EXPECT_EQ(meeting.bases, (std::vector<int>{1, 2, 3, 4, 5}));
    ASSERT_EQ(meeting.a_landmarks.size(), 4U);
    ASSERT_EQ(meeting.b_landmarks.size(), 5U);
    const Eigen::VectorXd x = coordinates(point, meeting.bases);
    const auto of_a = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
      return encounter(point.a, point.b, moved(point, meeting.bases, v), kEverywhere).problem.predicted;
    };
    const auto of_b = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
      return encounter(point.a, point.b, moved(point, meeting.bases, v), kEverywhere).problem.observed;
    };
    EXPECT_TRUE(jacobians_agree(meeting.J_a, numeric_jacobian(of_a, x))) << i;
    EXPECT_TRUE(jacobians_agree(meeting.J_b, numeric_jacobian(of_b, x))) << i;
  }
}

TEST(LoopCandidates, J7_CovariancesOfTheEncounter) {
  Rng rng(432);
  const Meeting point(rng, 0);
  const GlobalMap global = global_map_at(point.bases);
  const Encounter meeting = encounter(point.a, point.b, global, kEverywhere);
  const Eigen::MatrixXd P = global.covariance(meeting.bases);
  EXPECT_EQ(meeting.P_bases, P);
  // noise of b: its conditional covariance turned into a's frame
  const Eigen::Matrix2d R = (point.base(1).inverse() * point.base(4)).rotation();
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(10, 10);
  for (Eigen::Index i = 0; i < 10; i += 2) turn.block<2, 2>(i, i) = R;
  const Eigen::MatrixXd noise_b = turn * point.b.conditional_covariance().bottomRightCorner(10, 10) * turn.transpose();
  EXPECT_LE((meeting.noise_a - point.a.conditional_covariance()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LE((meeting.noise_b - noise_b).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd predicted = meeting.J_a * P * meeting.J_a.transpose() + point.a.conditional_covariance();
  const Eigen::MatrixXd observed = meeting.J_b * P * meeting.J_b.transpose() + noise_b;
  const double scale = observed.cwiseAbs().maxCoeff();
  EXPECT_LE((meeting.problem.predicted_covariance - predicted).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_LE((meeting.problem.observed_covariance - observed).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_LE((meeting.problem.cross_covariance - meeting.J_a * P * meeting.J_b.transpose()).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_FALSE(meeting.problem.second_component_is_angle);
}

TEST(LoopCandidates, J7_OnlyWhatIsWithinReachIsLookedAt) {
  // a: landmarks at x = 0 and 10, b: landmarks at x = 12 and 30 of the same frame; circles: centre 5, radius 5, and centre 21, radius 9.
  LiveMap a;
  a.base = 1;
  a.poses = {2};
  a.landmarks.resize(2);
  a.mean = Eigen::VectorXd::Zero(7);
  a.mean << 1.0, 0.0, 0.0, 0.0, 0.0, 10.0, 0.0;
  a.covariance = 0.01 * Eigen::MatrixXd::Identity(7, 7);
  LiveMap b = a;
  b.base = 3;
  b.poses = {4};
  b.mean << 1.0, 0.0, 0.0, 12.0, 0.0, 30.0, 0.0;
  set_ports(a, {true});
  set_ports(b, {true});
  const GlobalMap global = global_map_at({{}, {1.0, 0.0, 0.0}, {}, {1.0, 0.0, 0.0}});
  EXPECT_EQ(encounter(a, b, global, 1.9).a_landmarks, std::vector<Eigen::Index>{});
  EXPECT_EQ(encounter(a, b, global, 2.1).a_landmarks, std::vector<Eigen::Index>{1});
  EXPECT_EQ(encounter(a, b, global, 2.1).b_landmarks, std::vector<Eigen::Index>{0});
  EXPECT_EQ(encounter(a, b, global, 1.9).b_landmarks, std::vector<Eigen::Index>{});
  const Encounter both = encounter(a, b, global, 20.1);
  EXPECT_EQ(both.b_landmarks, (std::vector<Eigen::Index>{0, 1}));
  const std::vector<Pair> pairs = landmark_pairs(encounter(a, b, global, 2.1), {{0, 0}});
  EXPECT_EQ(pairs, (std::vector<Pair>{{0, 1}}));  // b's first, a's second landmark
}

TEST(LoopCandidates, J6_PlacementOfTwoMaps) {
  Rng rng(433);
  for (int i = 0; i < 20; ++i) {
    const Meeting point(rng, i);
    const GlobalMap global = global_map_at(point.bases);
    const RelativePlacement placement = relative_placement(point.a, point.b, global);
    const auto centroid = [&](const Eigen::VectorXd& x) -> Eigen::Vector2d {
      return Se2::from_vector(x.head<3>()).inverse() * (Se2::from_vector(x.tail<3>()) * point.b.centroid);
    };
    const Eigen::VectorXd x = coordinates(point, {1, 4});
    const Eigen::MatrixXd J = numeric_jacobian(centroid, x);
    const Eigen::Matrix2d P = J * global.covariance({1, 4}) * J.transpose();
    const double trace = P.trace();
    const double largest = 0.5 * (trace + std::sqrt(trace * trace - 4.0 * P.determinant()));
    EXPECT_NEAR(placement.sigma_m, std::sqrt(largest), 1e-6 * std::sqrt(largest));
    EXPECT_NEAR(placement.gap_m, (centroid(x) - point.a.centroid).norm() - point.a.radius - point.b.radius, 1e-9);
  }
}

TEST(LoopCandidates, J6_SigmaOfAPairLeavesOutTheLandmarksOwnNoise) {
  // Bases a and b at the same place, b uncertain by 0.3 m in x and 0.5 m in y, a known: the pairs' displacement has just that.
  GlobalMap global(GlobalSolver::kInvariantEkf, 10);
  Rng rng(434);
  LiveMap tie = random_map(rng, 0, {1}, 1, 0, 0.1);
  tie.mean.setZero();
  tie.covariance = 1e-12 * Eigen::Matrix3d::Identity();
  global.attach(tie);
  tie.poses = {2};
  tie.covariance = Eigen::Vector3d(0.09, 0.25, 1e-12).asDiagonal();
  global.attach(tie);
  LiveMap a = random_map(rng, 1, {3}, 1, 3, 0.1);
  LiveMap b = random_map(rng, 2, {4}, 1, 3, 0.1);
  for (LiveMap* map : {&a, &b}) {  // the exits add nothing: independent of the landmarks
    map->covariance.topRightCorner(3, 6).setZero();
    map->covariance.bottomLeftCorner(6, 3).setZero();
    set_ports(*map, {true});
    global.attach(*map);
  }
  const Encounter meeting = encounter(a, b, global, kEverywhere);
  EXPECT_NEAR(displacement_sigma(meeting, {{0, 0}, {1, 2}}), 0.5, 1e-6);
  EXPECT_EQ(displacement_sigma(meeting, {}), 0.0);
}

TEST(LoopCandidates, J13_EvidenceOfAPairing) {
  Rng rng(435);
  const Meeting point(rng, 3);
  const Encounter meeting = encounter(point.a, point.b, global_map_at(point.bases), kEverywhere);
  const std::vector<Pair> pairs{{4, 0}, {1, 2}, {2, 3}};
  const JoinEvidence evidence = evidence_of(meeting, pairs);
  EXPECT_EQ(evidence.bases, meeting.bases);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index p = 2 * pairs[static_cast<std::size_t>(i)].prediction;
    const Eigen::Index q = 2 * pairs[static_cast<std::size_t>(i)].observation;
    EXPECT_EQ(evidence.residual.segment<2>(2 * i), (meeting.problem.predicted.segment<2>(p) - meeting.problem.observed.segment<2>(q)));
    for (Eigen::Index j = 0; j < 3; ++j) {
      const Eigen::Index p_j = 2 * pairs[static_cast<std::size_t>(j)].prediction;
      const Eigen::Index q_j = 2 * pairs[static_cast<std::size_t>(j)].observation;
      EXPECT_EQ((evidence.noise.block<2, 2>(2 * i, 2 * j)), (meeting.noise_a.block<2, 2>(p, p_j) + meeting.noise_b.block<2, 2>(q, q_j)));
    }
  }
  const auto residual = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    return evidence_of(encounter(point.a, point.b, moved(point, meeting.bases, v), kEverywhere), pairs).residual;
  };
  EXPECT_TRUE(jacobians_agree(evidence.J, numeric_jacobian(residual, coordinates(point, meeting.bases))));
}

}  // namespace
}  // namespace ssjs
