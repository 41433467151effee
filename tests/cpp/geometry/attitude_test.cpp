#include "ssjs/geometry/attitude.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;

TEST(AttitudeTest, SS1_AxesTurnAsTheMarineConventionSays) {
  const double angle = 0.3;
  // Nose up: the bow rises, and up is -z. Starboard down: starboard sinks. Heading turns the bow to starboard.
  EXPECT_NEAR((rotation({0, angle, 0}) * Eigen::Vector3d::UnitX()).z(), -std::sin(angle), 1e-15);
  EXPECT_NEAR((rotation({angle, 0, 0}) * Eigen::Vector3d::UnitY()).z(), std::sin(angle), 1e-15);
  EXPECT_NEAR((rotation({0, 0, angle}) * Eigen::Vector3d::UnitX()).y(), std::sin(angle), 1e-15);
  const Attitude all{0.2, -0.4, 2.9};
  EXPECT_TRUE((rotation(all) * rotation(all).transpose()).isApprox(Eigen::Matrix3d::Identity(), 1e-14));
}

TEST(AttitudeTest, SS1_DerivativesAreCentralDifferences) {
  Rng rng(3);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Eigen::Vector3d angles(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-3, 3));
    const Eigen::Vector3d p(rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-9, 9));
    const auto turned = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d { return rotation({a.x(), a.y(), a.z()}) * p; };
    const Attitude attitude{angles.x(), angles.y(), angles.z()};
    Eigen::Matrix3d J;
    J << rotation_by_roll(attitude) * p, rotation_by_pitch(attitude) * p, rotation_by_heading(attitude) * p;
    EXPECT_TRUE(jacobians_agree(J, numeric_jacobian(turned, angles)));
  }
}

}  // namespace
}  // namespace ssjs
