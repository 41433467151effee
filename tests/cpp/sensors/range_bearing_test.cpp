#include "ssjs/sensors/range_bearing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

/// 1.5 to 40 m away: nearer the second derivatives of the bearing swamp a central difference.
Eigen::Vector2d random_landmark(Rng& rng, const Se2& pose, int point) {
  // every third one lies straight behind, where the bearing wraps
  const double bearing = point % 3 == 0 ? kPi + rng.uniform(-1e-4, 1e-4) : rng.uniform(-kPi, kPi);
  const double range = rng.uniform(1.5, 40.0);
  return pose.translation() + range * Eigen::Vector2d(std::cos(pose.heading + bearing), std::sin(pose.heading + bearing));
}

TEST(RangeBearing, M9_ATriangleByHand) {
  // from (1, 1) looking along +y, the point (-2, 5) lies 4 ahead and 3 to the left
  const RangeBearingPrediction prediction = predict_range_bearing({1.0, 1.0, kPi / 2.0}, {-2.0, 5.0});
  EXPECT_NEAR(prediction.range_bearing(0), 5.0, 1e-12);
  EXPECT_NEAR(prediction.range_bearing(1), std::atan2(3.0, 4.0), 1e-12);
}

TEST(RangeBearing, M9_BearingsStayInsideTheCircle) {
  const RangeBearingPrediction prediction = predict_range_bearing({0.0, 0.0, 3.0}, {std::cos(-3.0), std::sin(-3.0)});
  EXPECT_NEAR(prediction.range_bearing(1), 2.0 * kPi - 6.0, 1e-12);
}

TEST(RangeBearing, M10_Jacobians) {
  Rng rng(81);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const Eigen::Vector2d landmark = random_landmark(rng, pose, point);
    const RangeBearingPrediction prediction = predict_range_bearing(pose, landmark);
    const auto by_vehicle = [&](const Eigen::Vector3d& v) { return predict_range_bearing(Se2::from_vector(v), landmark).range_bearing; };
    const auto by_landmark = [&](const Eigen::Vector2d& v) { return predict_range_bearing(pose, v).range_bearing; };
    EXPECT_TRUE(jacobians_agree(prediction.H_vehicle, numeric_jacobian(by_vehicle, pose.vector(), {1})));
    EXPECT_TRUE(jacobians_agree(prediction.H_landmark, numeric_jacobian(by_landmark, landmark, {1})));
  }
}

TEST(RangeBearing, M11_PlacesTheLandmarkThatWouldGiveTheMeasurement) {
  Rng rng(82);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const Eigen::Vector2d landmark = random_landmark(rng, pose, point);
    const Eigen::Vector2d measured = predict_range_bearing(pose, landmark).range_bearing;
    EXPECT_NEAR((landmark_from_range_bearing(pose, measured).submap_p_landmark - landmark).norm(), 0.0, 1e-11);
  }
}

TEST(RangeBearing, M12_Jacobians) {
  Rng rng(83);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    // a measurement that no landmark of the map predicts exactly
    const Eigen::Vector2d measured(rng.uniform(0.5, 40.0), rng.uniform(-kPi, kPi));
    const LandmarkFromRangeBearing landmark = landmark_from_range_bearing(pose, measured);
    const auto by_vehicle = [&](const Eigen::Vector3d& v) {
      return landmark_from_range_bearing(Se2::from_vector(v), measured).submap_p_landmark;
    };
    const auto by_measurement = [&](const Eigen::Vector2d& v) { return landmark_from_range_bearing(pose, v).submap_p_landmark; };
    EXPECT_TRUE(jacobians_agree(landmark.J_vehicle, numeric_jacobian(by_vehicle, pose.vector())));
    EXPECT_TRUE(jacobians_agree(landmark.J_measurement, numeric_jacobian(by_measurement, measured)));
  }
}

TEST(RangeBearing, M10_M12_TheTwoModelsInvertEachOther) {
  // differentiating h(pose, l(pose, z)) = z: H_landmark J_measurement = I and H_vehicle + H_landmark J_vehicle = 0
  const Se2 pose{3.0, -7.0, 3.14};
  const Eigen::Vector2d measured(12.0, -2.0);
  const LandmarkFromRangeBearing landmark = landmark_from_range_bearing(pose, measured);
  const RangeBearingPrediction prediction = predict_range_bearing(pose, landmark.submap_p_landmark);
  EXPECT_NEAR((prediction.H_landmark * landmark.J_measurement - Eigen::Matrix2d::Identity()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((prediction.H_vehicle + prediction.H_landmark * landmark.J_vehicle).norm(), 0.0, 1e-12);
}

TEST(RangeBearing, BrokenContractsAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)predict_range_bearing({1.0, 2.0, 0.0}, {1.0, 2.0}), InvalidArgument);
  EXPECT_THROW((void)predict_range_bearing({1.0, 2.0, 0.0}, {nan, 2.0}), InvalidArgument);
  EXPECT_THROW((void)landmark_from_range_bearing({}, {-1.0, 0.0}), InvalidArgument);
  EXPECT_THROW((void)landmark_from_range_bearing({}, {nan, 0.0}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
