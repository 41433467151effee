#include "ssjs/joining/port_level.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/batch_ports.hpp"
#include "ssjs/joining/recursive_ports.hpp"

namespace ssjs {
namespace {

using testing::survey_maps;
using testing::survey_world;

constexpr double kNever = std::numeric_limits<double>::infinity();

PortJoinerConfig known(PortSolver solver) {
  PortJoinerConfig config;
  config.solver = solver;
  config.association = AssociationMethod::kKnown;
  config.relinearize_heading_rad = kNever;
  return config;
}

std::vector<Unknown> all_unknowns(const PortValues& values) {
  std::vector<Unknown> all;
  for (std::size_t i = 1; i < values.bases.size(); ++i) all.push_back({UnknownKind::kBase, static_cast<int>(i)});
  for (std::size_t i = 0; i < values.offsets.size(); ++i) all.push_back({UnknownKind::kOffset, static_cast<int>(i)});
  for (std::size_t i = 0; i < values.landmarks.size(); ++i) all.push_back({UnknownKind::kLandmark, static_cast<int>(i)});
  return all;
}

Eigen::VectorXd stacked(const PortValues& values) {
  const auto count = static_cast<Eigen::Index>(3 * (values.bases.size() - 1) + values.offsets.size() + 3 * values.landmarks.size());
  Eigen::VectorXd y(count);
  Eigen::Index at = 0;
  for (std::size_t i = 1; i < values.bases.size(); ++i, at += 3) y.segment<3>(at) = values.bases[i].vector();
  for (const double offset : values.offsets) y(at++) = offset;
  for (const Eigen::Vector3d& landmark : values.landmarks) {
    y.segment<3>(at) = landmark;
    at += 3;
  }
  return y;
}

PortValues unstacked(const Eigen::VectorXd& y, const PortValues& shape) {
  PortValues values = shape;
  Eigen::Index at = 0;
  for (std::size_t i = 1; i < values.bases.size(); ++i, at += 3) values.bases[i] = Se2::from_vector(y.segment<3>(at));
  for (double& offset : values.offsets) offset = y(at++);
  for (Eigen::Vector3d& landmark : values.landmarks) {
    landmark = y.segment<3>(at);
    at += 3;
  }
  return values;
}

/// A heading known better than this differs by rounding only: it is not measured in its own standard deviations.
constexpr double kSmallestSigma = 1e-5;

/// Largest difference of two levels in standard deviations, of values and of covariances.
std::pair<double, double> difference(const PortLevel& a, const PortLevel& b) {
  const std::vector<Unknown> all = all_unknowns(a.values());
  const Eigen::MatrixXd P = b.covariance(all);
  Eigen::VectorXd d = stacked(a.values()) - stacked(b.values());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    if (std::abs(d(i)) > 6.0) d(i) = wrap_angle(d(i));  // no position differs by so much here
  }
  return {(d.array() / P.diagonal().array().sqrt().max(kSmallestSigma)).abs().maxCoeff<Eigen::PropagateNaN>(),
          testing::covariance_difference(a.covariance(all), P)};
}

/// Headings are known to 1e-12 rad, positions to 100 m: what is left is linear. A heading near 1 is rounded to 1e-16, a thousandth of its
/// standard deviation, so nothing may follow it.
testing::MapNoise linear_noise() { return {100.0, 1e-12, 0.02, 0.01, 100.0, true}; }

TEST(PortLevel, P7_P8_RecursiveEqualsBatchInALinearWorld) {
  for (const CompassPorts compass : {CompassPorts::kBorders, CompassPorts::kConstant, CompassPorts::kNone}) {
    Rng rng(11);
    const testing::LevelledWorld world = survey_world(rng);
    PortJoiner recursive(known(PortSolver::kRecursive));
    PortJoiner batch(known(PortSolver::kBatch));
    for (const LevelledSubmap& map : survey_maps(world, linear_noise(), compass, rng)) {
      static_cast<void>(recursive.take(map));
      static_cast<void>(batch.take(map));
    }
    ASSERT_GT(batch.level().values().landmarks.size(), 25u);
    const auto [values, covariance] = difference(recursive.level(), batch.level());
    EXPECT_LT(values, 1e-9);
    EXPECT_LT(covariance, 1e-9);
  }
}

TEST(PortLevel, P9_RecursiveStaysCloseToBatchInTheRealWorldAndEqualsItAfterRelinearization) {
  Rng rng(12);
  const testing::LevelledWorld world = survey_world(rng);
  PortJoiner recursive(known(PortSolver::kRecursive));
  PortJoiner batch(known(PortSolver::kBatch));
  for (const LevelledSubmap& map : survey_maps(world, {}, CompassPorts::kBorders, rng)) {
    static_cast<void>(recursive.take(map));
    static_cast<void>(batch.take(map));
  }
  const auto [values, covariance] = difference(recursive.level(), batch.level());
  EXPECT_LT(values, 0.5);
  EXPECT_LT(covariance, 0.2);
  recursive.finish();
  const auto [values_after, covariance_after] = difference(recursive.level(), batch.level());
  EXPECT_LT(values_after, 1e-5);
  EXPECT_LT(covariance_after, 1e-6);
}

/// Everything the maps say, stacked, as one nonlinear least-squares problem with numerical Jacobians.
TEST(PortLevel, P6_BatchIsTheLeastSquaresSolutionOfAllMaps) {
  Rng rng(13);
  const testing::LevelledWorld world = survey_world(rng, 120.0);
  std::vector<LevelledSubmap> maps = survey_maps(world, {}, CompassPorts::kBorders, rng);
  maps.resize(5);
  PortJoiner batch(known(PortSolver::kBatch));
  for (const LevelledSubmap& map : maps) static_cast<void>(batch.take(map));
  const PortValues& solution = batch.level().values();
  ASSERT_GT(solution.landmarks.size(), 5u);
  Eigen::Index rows = 0;
  for (const PortMap& map : batch.maps()) rows += state_rows(map.ports).size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
  Eigen::Index at = 0;
  for (const PortMap& map : batch.maps()) {
    const Eigen::VectorXi of_map = state_rows(map.ports);
    P.block(at, at, of_map.size(), of_map.size()) = map.submap.covariance(of_map, of_map);
    at += of_map.size();
  }
  const auto residual = [&](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    const PortValues values = unstacked(y, solution);
    Eigen::VectorXd r(rows);
    Eigen::Index row = 0;
    for (const PortMap& map : batch.maps()) {
      const Eigen::VectorXi of_map = state_rows(map.ports);
      r.segment(row, of_map.size()) = port_difference(map.ports, place_ports(map.base(), map.ports, values).s, map.submap.mean(of_map));
      row += of_map.size();
    }
    return r;
  };
  const testing::BatchSolution oracle = testing::solve_batch(stacked(solution), residual, P);
  const Eigen::VectorXd sigmas = oracle.covariance.diagonal().array().sqrt();
  EXPECT_LT(((stacked(solution) - oracle.y).array() / sigmas.array()).abs().maxCoeff(), 1e-4);
  EXPECT_LT(testing::covariance_difference(batch.level().covariance(all_unknowns(solution)), oracle.covariance), 1e-4);
}

TEST(PortLevel, P4_NorthPriorTurnsTheWorldAndNothingElse) {
  Rng rng(14);
  const testing::LevelledWorld world = survey_world(rng);
  const std::vector<LevelledSubmap> maps = survey_maps(world, {}, CompassPorts::kBorders, rng);
  PortJoinerConfig north = known(PortSolver::kBatch);
  north.north_offset_rad = 0.2;  // the truth in the frame of the first base is 0.7: its heading is about 0.5
  north.north_offset_sigma_rad = 0.03;
  PortJoinerConfig north_recursive = north;
  north_recursive.solver = PortSolver::kRecursive;
  PortJoiner own(known(PortSolver::kBatch));
  PortJoiner batch(north);
  PortJoiner recursive(north_recursive);
  for (const LevelledSubmap& map : maps) {
    static_cast<void>(own.take(map));
    static_cast<void>(batch.take(map));
    static_cast<void>(recursive.take(map));
  }
  recursive.finish();
  const PortLevel& level = batch.level();
  // c_0 is seen by the maps relative to base headings only: the prior is all there is about the turn of the world
  EXPECT_NEAR(level.values().offset(0), 0.2, 1e-9);
  EXPECT_NEAR(level.covariance({{UnknownKind::kOffset, 0}})(0, 0), 0.03 * 0.03, 1e-12);
  const Se2 north_T_own{0.0, 0.0, level.values().base(0).heading};
  EXPECT_NEAR(north_T_own.heading, 0.5, 0.1);
  for (std::size_t k = 0; k < level.values().bases.size(); ++k) {
    EXPECT_LT(additive_difference(level.values().bases[k], north_T_own * own.level().values().bases[k]).norm(), 1e-5);
  }
  const auto [values, covariance] = difference(recursive.level(), level);
  EXPECT_LT(values, 1e-4);
  EXPECT_LT(covariance, 1e-6);
}

/// Error of a chain of links and nothing else, and of a survey with ports, over many worlds: as large as stated.
TEST(PortLevel, P6_ErrorsAreAsLargeAsTheyClaimOverTwentySurveys) {
  double joint = 0.0;
  double position = 0.0;
  double heading = 0.0;
  constexpr int kSeeds = 20;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(100 + static_cast<std::uint64_t>(seed));
    const testing::LevelledWorld world = survey_world(rng);
    PortJoiner joiner(known(PortSolver::kBatch));
    for (const LevelledSubmap& map : survey_maps(world, {}, CompassPorts::kBorders, rng)) static_cast<void>(joiner.take(map));
    const testing::BaseErrors errors = testing::base_errors(joiner.level(), world.bases);
    joint += errors.joint_per_dof / kSeeds;
    position += errors.position / kSeeds;
    heading += errors.heading / kSeeds;
  }
  RecordProperty("joint_nees_per_dof", std::to_string(joint));
  EXPECT_GT(joint, 0.85);
  EXPECT_LT(joint, 1.15);
  EXPECT_LT(position, 3.0);
  EXPECT_LT(heading, 1.6);
}

/// With compass factors a map (variant A) and a drift between them, every offset is its own unknown.
TEST(PortLevel, P4_AFactorPerMapIsConsistentWhereTheOffsetDrifts) {
  double joint = 0.0;
  constexpr int kSeeds = 12;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(200 + static_cast<std::uint64_t>(seed));
    const double walk = 0.0009;  // rad / sqrt(s): 0.0048 over a map
    const testing::LevelledWorld world = survey_world(rng, 50.0, walk * std::sqrt(30.0));
    PortJoinerConfig config = known(seed % 2 == 0 ? PortSolver::kBatch : PortSolver::kRecursive);
    config.offset_drift_rad_per_sqrt_s = walk;
    config.relinearize_heading_rad = 0.01;
    PortJoiner joiner(config);
    for (LevelledSubmap map : survey_maps(world, {}, CompassPorts::kNone, rng)) {
      const auto k = static_cast<std::size_t>(map.index);
      const double sigma = 0.004;
      map.compass_mean = CompassMean{wrap_angle(world.bases[k].heading + world.offsets[k] + rng.normal(sigma)), sigma * sigma,
                                     0.5 * (map.start_time_s + map.end_time_s)};
      static_cast<void>(joiner.take(map));
    }
    EXPECT_EQ(joiner.level().values().offsets.size(), joiner.maps().size());
    joint += testing::base_errors(joiner.level(), world.bases).joint_per_dof / kSeeds;
  }
  EXPECT_GT(joint, 0.8);
  EXPECT_LT(joint, 1.2);
}

/// An offset taken for constant that drifts is the dangerous case: the errors claimed are far too small.
TEST(PortLevel, P4_AConstantOffsetIsOverconfidentWhereItDrifts) {
  double joint = 0.0;
  constexpr int kSeeds = 8;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Rng rng(300 + static_cast<std::uint64_t>(seed));
    const testing::LevelledWorld world = survey_world(rng);
    PortJoiner joiner(known(PortSolver::kBatch));
    for (LevelledSubmap map : survey_maps(world, {}, CompassPorts::kNone, rng)) {
      const auto k = static_cast<std::size_t>(map.index);
      map.compass_mean = CompassMean{wrap_angle(world.bases[k].heading + world.offsets[k] + rng.normal(0.001)), 1e-6,
                                     0.5 * (map.start_time_s + map.end_time_s)};
      static_cast<void>(joiner.take(map));
    }
    joint += testing::base_errors(joiner.level(), world.bases).joint_per_dof / kSeeds;
  }
  EXPECT_GT(joint, 3.0);
}

TEST(PortLevel, UnknownsComeInOrder) {
  Rng rng(15);
  const testing::LevelledWorld world = survey_world(rng);
  const PortMap map{survey_maps(world, {}, CompassPorts::kNone, rng).front(), {}};
  BatchPorts batch;
  EXPECT_THROW(batch.introduce(map, {{0, {UnknownKind::kBase, 2}}}), InvalidArgument);
  RecursivePorts recursive(kNever);
  EXPECT_THROW(recursive.introduce(map, {{0, {UnknownKind::kBase, 2}}}), InvalidArgument);
  EXPECT_THROW(RecursivePorts(0.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
