#include "ssjs/geometry/se2.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "geometry/numeric_jacobian.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

constexpr double kRounding = 1e-12;

void expect_pose(const Se2& pose, double x, double y, double heading) {
  EXPECT_NEAR(pose.x, x, kRounding);
  EXPECT_NEAR(pose.y, y, kRounding);
  EXPECT_NEAR(angle_difference(pose.heading, heading), 0.0, kRounding);
}

Eigen::Vector2d random_point(Rng& rng) { return {rng.uniform(-20.0, 20.0), rng.uniform(-20.0, 20.0)}; }

TEST(Se2, S1_ComposesAndActsByHand) {
  // a stands at (1, 2) and looks along +y, so a step of (3, 4) in its frame goes 3 up and 4 to the left
  const Se2 a{1.0, 2.0, kPi / 2.0};
  expect_pose(a * Se2{3.0, 4.0, kPi / 4.0}, 1.0 - 4.0, 2.0 + 3.0, 3.0 * kPi / 4.0);
  const Eigen::Vector2d p = a * Eigen::Vector2d(3.0, 4.0);
  EXPECT_NEAR(p.x(), -3.0, kRounding);
  EXPECT_NEAR(p.y(), 5.0, kRounding);
}

TEST(Se2, S1_CompositionKeepsHeadingsInsideTheCircle) {
  const Se2 turned = Se2{0.0, 0.0, 3.0} * Se2{0.0, 0.0, 3.0};
  EXPECT_NEAR(turned.heading, 6.0 - 2.0 * kPi, kRounding);
  EXPECT_EQ(Se2::from_vector({0.0, 0.0, kPi}).heading, -kPi);
}

TEST(Se2, S1_InverseByHandAndAsIdentity) {
  // seen from a at (1, 2) looking along +y, the origin lies 2 behind and 1 to the left
  expect_pose(Se2{1.0, 2.0, kPi / 2.0}.inverse(), -2.0, 1.0, -kPi / 2.0);
  Rng rng(11);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 a = random_pose(rng, point);
    expect_pose(a * a.inverse(), 0.0, 0.0, 0.0);
    expect_pose(a.inverse() * a, 0.0, 0.0, 0.0);
  }
}

TEST(Se2, S1_CompositionIsAssociativeAndActsInTurn) {
  Rng rng(12);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 a = random_pose(rng, point);
    const Se2 b = random_pose(rng, point + 1);
    const Se2 c = random_pose(rng, point + 2);
    const Se2 left = (a * b) * c;
    expect_pose(a * (b * c), left.x, left.y, left.heading);
    const Eigen::Vector2d p = random_point(rng);
    EXPECT_NEAR(((a * b) * p - a * (b * p)).norm(), 0.0, kRounding);
  }
}

TEST(Se2, AdditiveStepUndoesAdditiveDifference) {
  const Se2 a{1.0, 2.0, 3.1};
  const Se2 b{4.0, -2.0, -3.1};
  EXPECT_NEAR(additive_difference(b, a).z(), 2.0 * kPi - 6.2, kRounding);  // across pi, not around the circle
  expect_pose(additive_step(a, additive_difference(b, a)), 4.0, -2.0, -3.1);
}

TEST(Se2, S2_S3_CompositionJacobians) {
  Rng rng(13);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 a = random_pose(rng, point);
    const Se2 b = random_pose(rng, point + 1);
    const auto by_left = [&](const Eigen::Vector3d& v) { return (Se2::from_vector(v) * b).vector(); };
    const auto by_right = [&](const Eigen::Vector3d& v) { return (a * Se2::from_vector(v)).vector(); };
    EXPECT_TRUE(jacobians_agree(compose_jacobian_left(a, b), numeric_jacobian(by_left, a.vector(), {2})));
    EXPECT_TRUE(jacobians_agree(compose_jacobian_right(a), numeric_jacobian(by_right, b.vector(), {2})));
  }
}

TEST(Se2, S4_InverseJacobian) {
  Rng rng(14);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 a = random_pose(rng, point);
    const auto inverse = [](const Eigen::Vector3d& v) { return Se2::from_vector(v).inverse().vector(); };
    EXPECT_TRUE(jacobians_agree(inverse_jacobian(a), numeric_jacobian(inverse, a.vector(), {2})));
  }
}

TEST(Se2, S5_ActionJacobians) {
  Rng rng(15);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 a = random_pose(rng, point);
    const Eigen::Vector2d p = random_point(rng);
    const auto by_pose = [&](const Eigen::Vector3d& v) -> Eigen::Vector2d { return Se2::from_vector(v) * p; };
    const auto by_point = [&](const Eigen::Vector2d& v) -> Eigen::Vector2d { return a * v; };
    EXPECT_TRUE(jacobians_agree(act_jacobian(a, p), numeric_jacobian(by_pose, a.vector())));
    EXPECT_TRUE(jacobians_agree(a.rotation(), numeric_jacobian(by_point, p)));
  }
}

TEST(Se2, S6_RelativePoseAndItsJacobians) {
  Rng rng(16);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 i = random_pose(rng, point);
    const Se2 j = random_pose(rng, point + 3);
    const RelativePose relative = relative_pose(i, j);
    const Se2 recomposed = i * relative.i_T_j;
    expect_pose(recomposed, j.x, j.y, j.heading);
    const auto by_i = [&](const Eigen::Vector3d& v) { return relative_pose(Se2::from_vector(v), j).i_T_j.vector(); };
    const auto by_j = [&](const Eigen::Vector3d& v) { return relative_pose(i, Se2::from_vector(v)).i_T_j.vector(); };
    EXPECT_TRUE(jacobians_agree(relative.J_i, numeric_jacobian(by_i, i.vector(), {2})));
    EXPECT_TRUE(jacobians_agree(relative.J_j, numeric_jacobian(by_j, j.vector(), {2})));
  }
}

TEST(Se2, S7_ExponentialOfAQuarterTurnIsAnArc) {
  // speed r pi/2 and turn pi/2: a quarter of the circle of radius r
  const double r = 3.0;
  expect_pose(se2_exp({r * kPi / 2.0, 0.0, kPi / 2.0}), r, r, kPi / 2.0);
  expect_pose(se2_exp({2.0, -1.0, 0.0}), 2.0, -1.0, 0.0);
}

TEST(Se2, S7_LogarithmUndoesTheExponential) {
  Rng rng(17);
  for (int point = 0; point < kJacobianPoints; ++point) {
    // every third turn is tiny, where the series take over
    const double turn = point % 3 == 0 ? rng.uniform(-2e-4, 2e-4) : rng.uniform(-3.1, 3.1);
    const Eigen::Vector3d twist(rng.uniform(-10.0, 10.0), rng.uniform(-10.0, 10.0), turn);
    EXPECT_NEAR((se2_log(se2_exp(twist)) - twist).norm(), 0.0, 1e-11);  // the tangent loses digits next to pi
  }
}

TEST(Se2, S7_ExponentialIsTheLimitOfManySmallSteps) {
  const Eigen::Vector3d twist(1.0, 0.5, 2.0);
  const int steps = 1000;
  Se2 pose;
  for (int step = 0; step < steps; ++step) pose = pose * se2_exp(twist / steps);
  EXPECT_NEAR(additive_difference(pose, se2_exp(twist)).norm(), 0.0, 1e-10);
}

TEST(Se2, S8_InvariantFrameIsTheDerivativeOfARightPerturbation) {
  Rng rng(18);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const auto perturbed = [&](const Eigen::Vector3d& xi) { return (se2_exp(xi) * pose).vector(); };
    EXPECT_TRUE(jacobians_agree(invariant_frame(pose), numeric_jacobian(perturbed, Eigen::Vector3d(Eigen::Vector3d::Zero()), {2})));
  }
}

TEST(Se2, S8_InvariantFrameInvertsBySigns) {
  const Eigen::Matrix3d M = invariant_frame({3.0, -4.0, 1.0});
  Eigen::Matrix3d expected;
  expected << 1.0, 0.0, 4.0, 0.0, 1.0, 3.0, 0.0, 0.0, 1.0;
  EXPECT_EQ(M, expected);
}

}  // namespace
}  // namespace ssjs
