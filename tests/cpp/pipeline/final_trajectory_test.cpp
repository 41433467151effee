#include "ssjs/pipeline/final_trajectory.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

using testing::correlated_covariance;
using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

/// Two submaps of two steps each; the bases do not stand where the submaps think.
struct Mission {
  std::vector<Submap> submaps;
  WorldEstimate world;

  explicit Mission(Rng& rng, int point) {
    for (int k = 0; k < 3; ++k) world.global_T_base.push_back(random_pose(rng, point + k));
    const Eigen::MatrixXd P = correlated_covariance(rng, testing::state_sigmas(3, 0, 0.5));
    world.border_covariance = {P.topLeftCorner<6, 6>(), P.bottomRightCorner<6, 6>()};
    for (int k = 0; k < 2; ++k) {
      Submap submap;
      submap.index = k;
      const Se2 exit = world.global_T_base[static_cast<std::size_t>(k)].inverse() * world.global_T_base[static_cast<std::size_t>(k) + 1];
      submap.state.mean = additive_step(exit, Eigen::Vector3d(rng.normal(0.4), rng.normal(0.4), rng.normal(0.2))).vector();
      submap.state.covariance = Eigen::Matrix3d::Identity();
      for (int i = 0; i < 2; ++i) {
        SubmapStep step;
        step.time_s = 10.0 * k + i;
        step.base_T_vehicle = random_pose(rng, point + i);
        for (Eigen::Index c = 0; c < 9; ++c) step.exit_gain.data()[c] = rng.normal(0.5);
        step.conditional_covariance = correlated_covariance(rng, Eigen::Vector3d(0.1, 0.1, 0.02));
        step.covariance = step.conditional_covariance;
        submap.steps.push_back(step);
      }
      submaps.push_back(submap);
    }
  }
};

TEST(FinalTrajectory, C5_CovarianceFollowsBothBordersAndWhatTheyLeaveOpen) {
  Rng rng(501);
  for (int i = 0; i < kJacobianPoints; ++i) {
    const Mission mission(rng, i);
    const std::vector<TrajectoryPoint> trajectory = final_trajectory(mission.submaps, mission.world);
    ASSERT_EQ(trajectory.size(), 4U);
    for (std::size_t step = 0; step < 4; ++step) {
      const std::size_t k = step / 2;
      const auto pose = [&](const Eigen::Matrix<double, 6, 1>& borders) -> Eigen::Vector3d {
        Mission moved = mission;
        moved.world.global_T_base[k] = Se2::from_vector(borders.head<3>());
        moved.world.global_T_base[k + 1] = Se2::from_vector(borders.tail<3>());
        return final_trajectory(moved.submaps, moved.world)[step].global_T_vehicle.mean.vector();
      };
      Eigen::Matrix<double, 6, 1> borders;
      borders << mission.world.global_T_base[k].vector(), mission.world.global_T_base[k + 1].vector();
      const Eigen::Matrix<double, 3, 6> J = numeric_jacobian(pose, borders, {2});
      Eigen::Matrix3d R3 = Eigen::Matrix3d::Identity();
      R3.topLeftCorner<2, 2>() = mission.world.global_T_base[k].rotation();
      const Eigen::Matrix3d expected = J * mission.world.border_covariance[k] * J.transpose() +
                                       R3 * mission.submaps[k].steps[step % 2].conditional_covariance * R3.transpose();
      // the tolerance of a Jacobian times 50 m of lever and 0.25 m^2
      EXPECT_LE((trajectory[step].global_T_vehicle.covariance - expected).cwiseAbs().maxCoeff(), 1e-4 * expected.cwiseAbs().maxCoeff());
      EXPECT_EQ(trajectory[step].time_s, mission.submaps[k].steps[step % 2].time_s);
    }
  }
}

TEST(FinalTrajectory, C5_AStepHalfWayFollowsHalfOfTheCorrection) {
  // Exit believed at (10, 0), known at last to be at (10, 4): a step with gain 1/2 moves by (0, 2). The base itself has moved by (100, 0).
  Submap submap;
  submap.state.mean = Eigen::Vector3d(10.0, 0.0, 0.0);
  submap.state.covariance = Eigen::Matrix3d::Identity();
  SubmapStep half;
  half.base_T_vehicle = {5.0, 0.0, 0.0};
  half.exit_gain = 0.5 * Eigen::Matrix3d::Identity();
  half.conditional_covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
  half.covariance = half.conditional_covariance;
  submap.steps = {half};
  WorldEstimate world;
  world.global_T_base = {{100.0, 0.0, 0.0}, {110.0, 4.0, 0.0}};
  world.border_covariance = {Matrix6d::Zero()};
  const GaussianSe2 pose = final_trajectory({submap}, world)[0].global_T_vehicle;
  EXPECT_LE((pose.mean.vector() - Eigen::Vector3d(105.0, 2.0, 0.0)).norm(), 1e-12);
  EXPECT_LE((pose.covariance - half.conditional_covariance).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(FinalTrajectory, GlobalStepsStayWhereTheyAre) {
  Rng rng(502);
  Mission mission(rng, 0);
  mission.submaps[1].steps_are_global = true;
  const std::vector<TrajectoryPoint> trajectory = final_trajectory(mission.submaps, mission.world);
  ASSERT_EQ(trajectory.size(), 4U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(trajectory[2 + i].global_T_vehicle.mean.vector(), mission.submaps[1].steps[i].base_T_vehicle.vector());
    EXPECT_EQ(trajectory[2 + i].global_T_vehicle.covariance, mission.submaps[1].steps[i].covariance);
    EXPECT_NE(trajectory[i].global_T_vehicle.mean.vector(), mission.submaps[0].steps[i].base_T_vehicle.vector());
  }
}

}  // namespace
}  // namespace ssjs
