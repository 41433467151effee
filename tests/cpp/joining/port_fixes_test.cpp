#include "ssjs/joining/port_fixes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <utility>

#include "geometry/numeric_jacobian.hpp"
#include "joining/levelled_world.hpp"
#include "ssjs/evaluation/consistency.hpp"

namespace ssjs {
namespace {

using testing::survey_maps;
using testing::survey_world;

constexpr double kFixSigma_m = 1.5;

PortJoinerConfig known(PortSolver solver) {
  PortJoinerConfig config;
  config.solver = solver;
  config.association = AssociationMethod::kKnown;
  return config;
}

/// A fix of the vehicle at `base_p` of the base that truly stands at `base`.
BaseFix fix_of(const Se2& base, const Eigen::Vector2d& base_p, Rng& rng) {
  BaseFix fix;
  fix.base_p_vehicle = base_p;
  fix.fix.world_p_vehicle = base * base_p + testing::normal_vector(rng, 2) * kFixSigma_m;
  fix.fix.covariance = kFixSigma_m * kFixSigma_m * Eigen::Matrix2d::Identity();
  return fix;
}

/// The survey as it lies in the frame of the fixes.
testing::LevelledWorld moved(testing::LevelledWorld world, const Se2& fixes_T_world) {
  for (Se2& base : world.bases) base = fixes_T_world * base;
  for (double& offset : world.offsets) offset = wrap_angle(offset - fixes_T_world.heading);
  for (Eigen::Vector3d& landmark : world.landmarks) landmark.head<2>() = fixes_T_world * Eigen::Vector2d(landmark.head<2>());
  return world;
}

TEST(PortFixes, P30_JacobianOfAFix) {
  Rng rng(1);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    const Se2 base = testing::random_pose(rng, point);
    const Eigen::Vector2d base_p(rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0));
    const auto at = [&](const Eigen::Vector3d& x) -> Eigen::Vector2d { return place_fix(Se2::from_vector(x), base_p).world_p; };
    EXPECT_TRUE(testing::jacobians_agree(place_fix(base, base_p).J_base, testing::numeric_jacobian(at, base.vector())));
  }
}

TEST(PortFixes, P30_RecursiveEqualsBatchInALinearWorld) {
  Rng rng(2);
  const testing::LevelledWorld world = survey_world(rng);
  PortJoinerConfig config = known(PortSolver::kRecursive);
  config.relinearize_heading_rad = 1e9;
  config.fixes.start_heading_sigma_rad = 1e-12;  // what is left is linear
  PortJoiner recursive(config);
  config.solver = PortSolver::kBatch;
  PortJoiner batch(config);
  const testing::MapNoise linear{100.0, 1e-12, 0.02, 0.01, 100.0, true};
  for (LevelledSubmap& map : survey_maps(world, linear, CompassPorts::kBorders, rng)) {
    if (map.index % 5 == 2) map.exit_fix = fix_of(world.bases[static_cast<std::size_t>(map.index) + 1], {-0.5, 0.1}, rng);
    static_cast<void>(recursive.take(map));
    for (const FixAttempt& fix : batch.take(map).fixes) EXPECT_TRUE(fix.accepted);
  }
  for (std::size_t i = 0; i < world.bases.size(); ++i) {
    const Unknown base{UnknownKind::kBase, static_cast<int>(i)};
    const Eigen::Matrix2d P = batch.level().covariance({base}).topLeftCorner<2, 2>();
    const Eigen::Matrix2d Q = recursive.level().covariance({base}).topLeftCorner<2, 2>();
    const double sigma_m = std::sqrt(P.trace());
    EXPECT_LT((batch.level().values().bases[i].translation() - recursive.level().values().bases[i].translation()).norm(), 1e-8 * sigma_m);
    EXPECT_LT((P - Q).norm(), 1e-8 * P.norm());
  }
}

/// Where the survey lies, and how it is turned, is told by the fixes alone.
struct FixedSurveys {
  double joint_per_dof = 0.0;
  double start_position = 0.0;  ///< NEES of base 0, 2 degrees of freedom
  double start_heading = 0.0;   ///< 1 degree of freedom
  double heading_error_rad = 0.0, heading_sigma_rad = 0.0;
  double nis_per_dof = 0.0;
};
FixedSurveys fixed_surveys(int seeds, PortSolver solver) {
  FixedSurveys result;
  int judged = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Rng rng(900 + static_cast<std::uint64_t>(seed));
    const Se2 fixes_T_world{rng.uniform(-2000.0, 2000.0), rng.uniform(-2000.0, 2000.0), rng.normal(0.1)};
    const testing::LevelledWorld world = moved(survey_world(rng), fixes_T_world);
    PortJoiner joiner(known(solver));
    for (LevelledSubmap& map : survey_maps(world, {}, CompassPorts::kBorders, rng)) {
      if (map.index == 0) map.start_fix = fix_of(world.bases[0], {0.0, 0.0}, rng);
      if (map.index % 8 == 5) map.exit_fix = fix_of(world.bases[static_cast<std::size_t>(map.index) + 1], {-1.0, 0.2}, rng);
      for (const FixAttempt& fix : joiner.take(map).fixes) {
        EXPECT_TRUE(fix.accepted) << seed << " base " << fix.base;
        if (!fix.chi_squared) continue;
        result.nis_per_dof += 0.5 * *fix.chi_squared;
        ++judged;
      }
    }
    joiner.finish();
    std::vector<Unknown> bases;
    for (std::size_t k = 0; k < world.bases.size(); ++k) bases.push_back({UnknownKind::kBase, static_cast<int>(k)});
    const Eigen::MatrixXd P = joiner.level().covariance(bases);
    Eigen::VectorXd error(P.rows());
    for (std::size_t k = 0; k < world.bases.size(); ++k) {
      error.segment<3>(static_cast<Eigen::Index>(3 * k)) = additive_difference(joiner.level().values().bases[k], world.bases[k]);
    }
    result.joint_per_dof += error.dot(P.ldlt().solve(error)) / static_cast<double>(error.size()) / seeds;
    result.start_position += error.head<2>().dot(P.topLeftCorner<2, 2>().llt().solve(error.head<2>())) / seeds;
    result.start_heading += error(2) * error(2) / P(2, 2) / seeds;
    result.heading_error_rad += std::abs(error(2)) / seeds;
    result.heading_sigma_rad += std::sqrt(P(2, 2)) / seeds;
  }
  result.nis_per_dof /= judged;
  return result;
}

void expect_consistent(const FixedSurveys& surveys, int seeds) {
  std::printf("fixes: joint per dof %.3f, start position %.2f of 2, heading %.2f of 1 (|error| %.4f, sigma %.4f rad), NIS per dof %.2f\n",
              surveys.joint_per_dof, surveys.start_position, surveys.start_heading, surveys.heading_error_rad, surveys.heading_sigma_rad,
              surveys.nis_per_dof);
  for (const auto& [value, dof] : {std::pair{surveys.start_position, 2.0}, std::pair{surveys.start_heading, 1.0}}) {
    EXPECT_GT(value, mean_band(dof, seeds, 0.99).lower);
    EXPECT_LT(value, mean_band(dof, seeds, 0.99).upper);
  }
  EXPECT_NEAR(surveys.joint_per_dof, 1.0, 0.15);
  EXPECT_LT(surveys.heading_sigma_rad, 0.03);  // 1.5 m at the ends of 100 m; 0.1 rad before
}

TEST(PortFixes, P30_P31_ConsistentAboutWhereTheSurveyLiesAndHowItIsTurned) {
  expect_consistent(fixed_surveys(12, PortSolver::kBatch), 12);
  expect_consistent(fixed_surveys(4, PortSolver::kRecursive), 4);
}

TEST(PortFixes, P30_P31_ConsistentOver50SurveysLong) { expect_consistent(fixed_surveys(50, PortSolver::kBatch), 50); }

/// Maps with a fix at the start and at each of the last eight bases.
std::vector<LevelledSubmap> fixed_at_both_ends(const testing::LevelledWorld& world, Rng& rng) {
  std::vector<LevelledSubmap> maps = survey_maps(world, {}, CompassPorts::kBorders, rng);
  maps.front().start_fix = fix_of(world.bases.front(), {0.0, 0.0}, rng);
  for (std::size_t k = maps.size() - 8; k < maps.size(); ++k) maps[k].exit_fix = fix_of(world.bases[k + 1], {0.0, 0.0}, rng);
  return maps;
}

TEST(PortFixes, P32_AFixFarOffIsRefusedWithItsReasonAndChangesNothing) {
  Rng rng(5);
  const testing::LevelledWorld world = survey_world(rng);
  std::vector<LevelledSubmap> maps = fixed_at_both_ends(world, rng);
  PortJoiner clean(known(PortSolver::kBatch));
  PortJoiner lied_to(known(PortSolver::kBatch));
  for (LevelledSubmap& map : maps) {
    static_cast<void>(clean.take(map));
    const bool lies = map.index == 10;
    if (lies) {
      map.exit_fix = fix_of(world.bases[11], {0.0, 0.0}, rng);
      map.exit_fix->fix.world_p_vehicle.x() += 60.0;
    }
    const JoinReport report = lied_to.take(map);
    if (!lies) continue;
    ASSERT_EQ(report.fixes.size(), 1U);
    EXPECT_FALSE(report.fixes[0].accepted);
    EXPECT_EQ(report.fixes[0].reason, "outside the gate");
    EXPECT_NEAR(report.fixes[0].distance_m, 60.0, 10.0);
  }
  for (std::size_t i = 0; i < world.bases.size(); ++i) {
    EXPECT_EQ(clean.level().values().bases[i].vector(), lied_to.level().values().bases[i].vector());
  }
}

double squared_distance(const PortLevel& level, int base, const Se2& truth) {
  const Eigen::Matrix2d P = level.covariance({{UnknownKind::kBase, base}}).topLeftCorner<2, 2>();
  const Eigen::Vector2d error = level.values().base(base).translation() - truth.translation();
  return error.dot(P.llt().solve(error));
}

/// Map 10 says that the vehicle went on where it did not: 120 m to the side. What the heading of the start leaves open is a tenth of that.
TEST(PortFixes, P33_SeveralRefusedFixesThatAgreeSetTheEstimateRight) {
  for (const PortSolver solver : {PortSolver::kBatch, PortSolver::kRecursive}) {
    Rng rng(6);
    const testing::LevelledWorld world = survey_world(rng);
    PortJoinerConfig config = known(solver);
    config.fixes.relocate_after = 3;
    PortJoiner joiner(config);
    std::vector<bool> accepted;
    std::vector<bool> relocated;
    std::vector<LevelledSubmap> maps = fixed_at_both_ends(world, rng);
    const auto last = static_cast<int>(maps.size());
    for (LevelledSubmap& map : maps) {
      map.landmarks.clear();  // nothing but the fixes could tell
      map.seen_s.clear();
      map.mean.conservativeResize(5);
      map.covariance.conservativeResize(5, 5);
      if (map.index == 10) map.mean(1) += 120.0;
      for (const FixAttempt& fix : joiner.take(map).fixes) {
        accepted.push_back(fix.accepted);
        relocated.push_back(fix.relocated);
      }
    }
    EXPECT_EQ(accepted, (std::vector<bool>{true, false, false, true, true, true, true, true, true}));
    EXPECT_EQ(relocated, (std::vector<bool>{false, false, false, true, false, false, false, false, false}));
    EXPECT_LT(squared_distance(joiner.level(), last, world.bases.back()), 9.0);
    EXPECT_LT((joiner.level().values().base(last).translation() - world.bases.back().translation()).norm(), 3.0);
    EXPECT_LT(squared_distance(joiner.level(), 10, world.bases[10]), 14.0);  // before the slip: as it was
  }
}

TEST(PortFixes, P33_RefusedFixesThatContradictEachOtherStayRefused) {
  Rng rng(7);
  const testing::LevelledWorld world = survey_world(rng);
  PortJoiner joiner(known(PortSolver::kBatch));
  int refused = 0;
  std::vector<LevelledSubmap> maps = fixed_at_both_ends(world, rng);
  for (std::size_t k = 0; k < maps.size(); ++k) {
    if (k + 8 >= maps.size())
      maps[k].exit_fix->fix.world_p_vehicle += Eigen::Vector2d(k % 2 == 0 ? 80.0 : -80.0, 20.0 * static_cast<double>(k % 3));
    for (const FixAttempt& fix : joiner.take(maps[k]).fixes) refused += fix.accepted ? 0 : 1;
  }
  EXPECT_EQ(refused, 8);
}

TEST(PortFixes, P33_AnOperatorIsBelievedAtOnce) {
  Rng rng(8);
  const testing::LevelledWorld world = survey_world(rng);
  PortJoiner joiner(known(PortSolver::kBatch));
  for (LevelledSubmap& map : survey_maps(world, {}, CompassPorts::kBorders, rng)) {
    if (map.index == 0) map.start_fix = fix_of(world.bases[0], {0.0, 0.0}, rng);
    if (map.index == 9) {
      map.exit_fix =
          BaseFix{0.0, {0.0, 0.0}, {world.bases[10].translation() + Eigen::Vector2d(100.0, -50.0), Eigen::Matrix2d::Identity(), true}};
    }
    const JoinReport report = joiner.take(map);
    if (map.index != 9) continue;
    ASSERT_EQ(report.fixes.size(), 1U);
    EXPECT_TRUE(report.fixes[0].relocated);
    EXPECT_LT((joiner.level().values().base(10).translation() - world.bases[10].translation() - Eigen::Vector2d(100.0, -50.0)).norm(), 3.0);
    return;
  }
}

/// r = (10, 0), S = I: 100 / (1 + v) = 2.
TEST(PortFixes, P33_TheMissingVarianceMakesTheDistanceItsMean) {
  EXPECT_NEAR(missing_variance({10.0, 0.0}, Eigen::Matrix2d::Identity()), 49.0, 1e-6);
  EXPECT_EQ(missing_variance({1.0, 0.5}, Eigen::Matrix2d::Identity()), 0.0);
}

TEST(PortFixes, P33_ALooserExitLeavesTheMarginalOfEveryStep) {
  Rng rng(9);
  const testing::LevelledWorld world = survey_world(rng);
  LevelledSubmap map = survey_maps(world, {}, CompassPorts::kBorders, rng).front();
  LevelledStep& step = map.steps.emplace_back();
  step.gain = 0.3 * Eigen::MatrixXd::Random(6, 5);
  step.conditional_covariance.setIdentity();
  const auto marginal = [](const LevelledSubmap& of) -> Eigen::MatrixXd {
    return of.steps[0].conditional_covariance + of.steps[0].gain * of.covariance.topLeftCorner(5, 5) * of.steps[0].gain.transpose();
  };
  const Eigen::MatrixXd before = marginal(map);
  const Eigen::MatrixXd with_exit = step.gain * map.covariance.topLeftCorner(5, 5);
  loosen_exit(map, 400.0);
  EXPECT_LT((marginal(map) - before).norm(), 1e-9);
  EXPECT_LT((map.steps[0].gain * map.covariance.topLeftCorner(5, 5) - with_exit).norm(), 1e-9);
}

}  // namespace
}  // namespace ssjs
