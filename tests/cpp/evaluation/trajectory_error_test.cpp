#include "ssjs/evaluation/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// A drive of n poses, one a second: a circle of 20 m radius, or 2 m/s straight along +x.
Trajectory circle(int n) {
  Trajectory trajectory;
  for (int i = 0; i < n; ++i) {
    const double angle = 0.1 * i;
    trajectory.time_s.push_back(i);
    trajectory.global_T_vehicle.push_back({20.0 * std::cos(angle), 20.0 * std::sin(angle), wrap_angle(angle + kPi / 2.0)});
  }
  return trajectory;
}

Trajectory straight(int n) {
  Trajectory trajectory;
  for (int i = 0; i < n; ++i) {
    trajectory.time_s.push_back(i);
    trajectory.global_T_vehicle.push_back({2.0 * i, 0.0, 0.0});
  }
  return trajectory;
}

Trajectory moved(const Se2& motion, const Trajectory& trajectory) {
  Trajectory result = trajectory;
  for (Se2& pose : result.global_T_vehicle) pose = motion * pose;
  return result;
}

ReferenceFixes fixes_of(const Trajectory& trajectory, const Eigen::Vector2d& vehicle_p_antenna, bool with_heading) {
  ReferenceFixes fixes;
  const Eigen::Index n = static_cast<Eigen::Index>(trajectory.time_s.size());
  fixes.time_s = trajectory.time_s;
  fixes.position_m.resize(2, n);
  fixes.vehicle_p_antenna = vehicle_p_antenna;
  if (with_heading) fixes.heading_rad = Eigen::VectorXd(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Se2& pose = trajectory.global_T_vehicle[static_cast<std::size_t>(i)];
    fixes.position_m.col(i) = pose * vehicle_p_antenna;
    if (with_heading) (*fixes.heading_rad)(i) = pose.heading;
  }
  return fixes;
}

TrajectoryErrorConfig with(Alignment alignment, std::optional<double> outlier_m = std::nullopt) { return {alignment, outlier_m, 1.0}; }

TEST(TrajectoryError, E1_InterpolatesBetweenPosesAlongTheShorterArc) {
  Trajectory estimate;
  estimate.time_s = {0.0, 1.0};
  estimate.global_T_vehicle = {{0.0, 0.0, 3.0}, {4.0, 2.0, -3.0}};
  ReferenceFixes fixes;
  fixes.time_s = {0.25};
  fixes.position_m = Eigen::Vector2d(1.0, 0.5);
  fixes.heading_rad = Eigen::VectorXd::Constant(1, 3.0 + 0.25 * (2.0 * kPi - 6.0));
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes, with(Alignment::kNone));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->rmse_m, 0.0, 1e-12);
  EXPECT_NEAR(*error->heading_rmse_rad, 0.0, 1e-12);
}

TEST(TrajectoryError, E1_FixesOutsideTheSpanOrInsideAGapAreNotCompared) {
  Trajectory estimate;
  estimate.time_s = {0.0, 1.0, 11.0, 12.0};
  estimate.global_T_vehicle = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {11.0, 0.0, 0.0}, {12.0, 0.0, 0.0}};
  ReferenceFixes fixes;
  fixes.time_s = {-0.5, 0.5, 1.5, 6.0, 10.8, 12.0, 12.5};
  fixes.position_m = Eigen::Matrix2Xd::Zero(2, 7);
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes, with(Alignment::kNone));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->time_s, (std::vector<double>{0.5, 1.5, 10.8, 12.0}));
  EXPECT_NEAR(error->error_m[1], 1.5, 1e-12);
  fixes.time_s.assign(7, 6.0);
  EXPECT_FALSE(trajectory_error(estimate, fixes, with(Alignment::kNone)));
}

TEST(TrajectoryError, E2_E5_StatisticsByHand) {
  // errors 0, 3, 4, 5 along a reference of 3 steps of 10 m
  Trajectory estimate;
  estimate.time_s = {0.0, 1.0, 2.0, 3.0};
  estimate.global_T_vehicle = {{0.0, 0.0, 0.0}, {10.0, 3.0, 0.0}, {24.0, 0.0, 0.0}, {33.0, -4.0, 0.0}};
  ReferenceFixes fixes;
  fixes.time_s = estimate.time_s;
  fixes.position_m.resize(2, 4);
  fixes.position_m << 0.0, 10.0, 20.0, 30.0, 0.0, 0.0, 0.0, 0.0;
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes, with(Alignment::kNone));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->compared, 4);
  EXPECT_EQ(error->outliers, 0);
  EXPECT_NEAR(error->mean_m, 3.0, 1e-12);
  EXPECT_NEAR(error->rmse_m, std::sqrt(12.5), 1e-12);  // (0 + 9 + 16 + 25) / 4
  EXPECT_NEAR(error->std_m, std::sqrt(12.5 - 9.0), 1e-12);
  EXPECT_NEAR(error->median_m, 3.5, 1e-12);
  EXPECT_NEAR(error->max_m, 5.0, 1e-12);
  EXPECT_NEAR(error->final_error_m, 5.0, 1e-12);
  EXPECT_NEAR(error->path_length_m, 30.0, 1e-12);
  EXPECT_NEAR(error->final_drift_percent, 100.0 * 5.0 / 30.0, 1e-12);
  EXPECT_FALSE(error->heading_rmse_rad);
}

TEST(TrajectoryError, E3_AlignmentTakesOutAnyMotion) {
  const Trajectory truth = circle(40);
  const Se2 estimate_T_reference{5.0, -7.0, 2.5};
  const Trajectory estimate = moved(estimate_T_reference, truth);
  for (const Alignment alignment : {Alignment::kSe2, Alignment::kYaw}) {
    const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes_of(truth, {3.69, 0.44}, true), with(alignment));
    ASSERT_TRUE(error);
    EXPECT_NEAR(error->max_m, 0.0, 1e-9);
    EXPECT_NEAR(*error->heading_rmse_rad, 0.0, 1e-9);
    EXPECT_NEAR(additive_difference(error->reference_T_estimate, estimate_T_reference.inverse()).norm(), 0.0, 1e-9);
  }
}

TEST(TrajectoryError, E3_AStraightTrackAligns) {
  const Trajectory truth = straight(50);
  const Se2 estimate_T_reference{5.0, -7.0, -1.2};
  const std::optional<TrajectoryError> error =
      trajectory_error(moved(estimate_T_reference, truth), fixes_of(truth, {0.0, 0.0}, false), with(Alignment::kSe2));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->max_m, 0.0, 1e-9);
  EXPECT_NEAR(angle_difference(error->reference_T_estimate.heading, 1.2), 0.0, 1e-12);
}

TEST(TrajectoryError, E3_OriginHoldsTheFirstFix) {
  const Trajectory truth = straight(11);
  Trajectory estimate = moved({5.0, -7.0, 1.0}, truth);
  estimate.global_T_vehicle.back().x += 3.0;
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes_of(truth, {1.0, 2.0}, true), with(Alignment::kOrigin));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->error_m.front(), 0.0, 1e-12);
  EXPECT_NEAR(error->error_m[9], 0.0, 1e-9);
  EXPECT_NEAR(error->final_error_m, 3.0, 1e-9);
  // without headings one fix says nothing about the rotation: only the place is taken over
  const std::optional<TrajectoryError> placed = trajectory_error(estimate, fixes_of(truth, {0.0, 0.0}, false), with(Alignment::kOrigin));
  ASSERT_TRUE(placed);
  EXPECT_EQ(placed->reference_T_estimate.heading, 0.0);
  EXPECT_NEAR(placed->error_m.front(), 0.0, 1e-12);
}

TEST(TrajectoryError, E3_AVehicleThatStoodStillAligns) {
  Trajectory truth;
  for (int i = 0; i < 5; ++i) {
    truth.time_s.push_back(i);
    truth.global_T_vehicle.push_back({100.0, 200.0, 0.7});
  }
  const Trajectory estimate = moved({5.0, -7.0, 1.0}, truth);
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes_of(truth, {0.0, 0.0}, true), with(Alignment::kSe2));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->max_m, 0.0, 1e-9);
  EXPECT_NEAR(*error->heading_rmse_rad, 0.0, 1e-12);
  EXPECT_EQ(error->final_drift_percent, 0.0);
  EXPECT_TRUE(trajectory_error(estimate, fixes_of(truth, {0.0, 0.0}, false), with(Alignment::kSe2)));
}

TEST(TrajectoryError, E3_OneFixAlignsByPlaceAlone) {
  Trajectory estimate;
  estimate.time_s = {0.0};
  estimate.global_T_vehicle = {{1.0, 2.0, 0.3}};
  ReferenceFixes fixes;
  fixes.time_s = {0.0};
  fixes.position_m = Eigen::Vector2d(7.0, 8.0);
  const std::optional<TrajectoryError> error = trajectory_error(estimate, fixes, with(Alignment::kSe2));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->rmse_m, 0.0, 1e-12);
  EXPECT_NEAR(error->reference_T_estimate.x, 6.0, 1e-12);
}

TEST(TrajectoryError, E4_OutliersAreRejectedAndCounted) {
  const Trajectory truth = circle(200);
  ReferenceFixes fixes = fixes_of(truth, {0.0, 0.0}, false);
  Rng rng(111);
  for (Eigen::Index i = 0; i < 200; ++i) fixes.position_m.col(i) += Eigen::Vector2d(rng.normal(0.1), rng.normal(0.1));
  fixes.position_m.col(10) += Eigen::Vector2d(15.0, 0.0);
  fixes.position_m.col(11) += Eigen::Vector2d(0.0, -30.0);
  const std::optional<TrajectoryError> error = trajectory_error(moved({9.0, 9.0, 3.0}, truth), fixes, with(Alignment::kSe2, 10.0));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->compared, 200);
  EXPECT_EQ(error->outliers, 2);
  EXPECT_TRUE(error->is_outlier[10]);
  EXPECT_TRUE(error->is_outlier[11]);
  EXPECT_NEAR(error->rmse_m, 0.1 * std::sqrt(2.0), 0.02);  // 198 fixes: deviation 0.005
  EXPECT_GT(error->error_m[11], 29.0);
}

TEST(TrajectoryError, E4_GrossErrorsThatBendTheFirstAlignmentAreFound) {
  // a fifth of the fixes lies a kilometre away: the alignment to all of them puts every fix beyond the limit
  const Trajectory truth = circle(100);
  ReferenceFixes fixes = fixes_of(truth, {0.0, 0.0}, false);
  for (Eigen::Index i = 0; i < 100; i += 5) fixes.position_m.col(i) += Eigen::Vector2d(1000.0, 500.0);
  const std::optional<TrajectoryError> error = trajectory_error(truth, fixes, with(Alignment::kSe2, 2.0));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->outliers, 20);
  EXPECT_NEAR(error->max_m, 0.0, 1e-9);
}

TEST(TrajectoryError, E4_AnOutlierAtTheEndIsNotTheFinalError) {
  const Trajectory truth = straight(20);
  ReferenceFixes fixes = fixes_of(truth, {0.0, 0.0}, false);
  fixes.position_m.col(19).y() += 50.0;
  const std::optional<TrajectoryError> error = trajectory_error(truth, fixes, with(Alignment::kNone, 10.0));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->final_error_m, 0.0, 1e-12);
  EXPECT_NEAR(error->path_length_m, 36.0, 1e-12);
  EXPECT_FALSE(trajectory_error(moved({0.0, 100.0, 0.0}, truth), fixes, with(Alignment::kNone, 10.0)));  // nothing is left to measure
}

TEST(TrajectoryError, TheLeverArmIsTakenIntoAccount) {
  // the antenna of a circling vehicle runs on another circle: without the lever arm the error is its length
  const Trajectory truth = circle(63);
  ReferenceFixes fixes = fixes_of(truth, {3.0, 0.0}, false);
  EXPECT_NEAR(trajectory_error(truth, fixes, with(Alignment::kNone))->max_m, 0.0, 1e-9);
  fixes.vehicle_p_antenna.setZero();
  EXPECT_NEAR(trajectory_error(truth, fixes, with(Alignment::kNone))->mean_m, 3.0, 1e-9);
}

TEST(TrajectoryError, BrokenContractsAreNamed) {
  const Trajectory truth = straight(3);
  const ReferenceFixes fixes = fixes_of(truth, {0.0, 0.0}, true);
  Trajectory backwards = truth;
  backwards.time_s[2] = 0.5;
  EXPECT_THROW((void)trajectory_error(backwards, fixes, {}), InvalidArgument);
  Trajectory short_of_poses = truth;
  short_of_poses.global_T_vehicle.pop_back();
  EXPECT_THROW((void)trajectory_error(short_of_poses, fixes, {}), InvalidArgument);
  ReferenceFixes broken = fixes;
  broken.position_m(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)trajectory_error(truth, broken, {}), InvalidArgument);
  ReferenceFixes unequal = fixes;
  unequal.heading_rad = Eigen::VectorXd::Zero(2);
  EXPECT_THROW((void)trajectory_error(truth, unequal, {}), InvalidArgument);
  EXPECT_THROW((void)trajectory_error(truth, fixes, with(Alignment::kSe2, 0.0)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
