#include "ssjs/sensors/odometry_increment.hpp"

#include <gtest/gtest.h>

#include "geometry/numeric_jacobian.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

TEST(OdometryIncrement, M8_MovesInTheFrameOfTheOldPose) {
  OdometryIncrement increment;
  increment.old_T_new.mean = {2.0, 1.0, kPi / 2.0};
  increment.old_T_new.covariance = Eigen::Vector3d(0.01, 0.04, 0.09).asDiagonal();
  // looking along +y, forward noise becomes noise in y
  const MotionPrediction prediction = predict_increment({5.0, 5.0, kPi / 2.0}, increment);
  EXPECT_NEAR(prediction.submap_T_vehicle.x, 4.0, 1e-12);
  EXPECT_NEAR(prediction.submap_T_vehicle.y, 7.0, 1e-12);
  EXPECT_NEAR(angle_difference(prediction.submap_T_vehicle.heading, kPi), 0.0, 1e-12);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.04, 0.01, 0.09).asDiagonal();
  EXPECT_NEAR((prediction.Q - expected).norm(), 0.0, 1e-12);
}

TEST(OdometryIncrement, DistancesAreCalibratedHeadingsAndNoiseAreNot) {
  OdometryIncrement measured;
  measured.old_T_new.mean = {2.0, -1.0, 0.3};
  measured.old_T_new.covariance = Eigen::Vector3d(0.01, 0.04, 0.09).asDiagonal();
  IncrementsConfig config;
  config.distance_scale = 0.9;
  const GaussianSe2 truer = calibrated(measured, config).old_T_new;
  EXPECT_NEAR(truer.mean.x, 1.8, 1e-12);
  EXPECT_NEAR(truer.mean.y, -0.9, 1e-12);
  EXPECT_EQ(truer.mean.heading, 0.3);
  EXPECT_EQ(truer.covariance, measured.old_T_new.covariance);
}

TEST(OdometryIncrement, M8_Jacobians) {
  Rng rng(71);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    OdometryIncrement increment;
    increment.old_T_new.mean = random_pose(rng, point + 1);
    increment.old_T_new.covariance << 0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.01;
    const MotionPrediction prediction = predict_increment(pose, increment);
    const auto by_pose = [&](const Eigen::Vector3d& v) {
      return predict_increment(Se2::from_vector(v), increment).submap_T_vehicle.vector();
    };
    const auto by_increment = [&](const Eigen::Vector3d& v) { return (pose * Se2::from_vector(v)).vector(); };
    EXPECT_TRUE(jacobians_agree(prediction.F, numeric_jacobian(by_pose, pose.vector(), {2})));
    const Eigen::Matrix3d J = numeric_jacobian(by_increment, increment.old_T_new.mean.vector(), {2});
    EXPECT_TRUE(jacobians_agree(prediction.Q, Eigen::Matrix3d(J * increment.old_T_new.covariance * J.transpose())));
  }
}

}  // namespace
}  // namespace ssjs
