#include "ssjs/geometry/se3.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;

constexpr double kRounding = 1e-12;

/// Every other yaw within 1e-4 rad of +-pi; pitch up to 70 degrees.
Eigen::Vector3d random_rpy(Rng& rng, int point) {
  const double side = point % 4 < 2 ? kPi : -kPi;
  const double yaw = point % 2 == 0 ? rng.uniform(-kPi, kPi) : side + rng.uniform(-1e-4, 1e-4);
  return {rng.uniform(-kPi, kPi), rng.uniform(-1.2, 1.2), wrap_angle(yaw)};
}

Eigen::Vector3d random_vector(Rng& rng, double size) {
  return {rng.uniform(-size, size), rng.uniform(-size, size), rng.uniform(-size, size)};
}

Se3 random_pose3(Rng& rng, int point) { return {random_vector(rng, 30.0), random_rpy(rng, point)}; }

/// Composition and inverse give a pitch of their own, which has to stay off the vertical for differences to mean anything.
bool is_steep(const Se3& pose) { return std::abs(std::cos(pose.rpy.y())) < 0.15; }

TEST(Se3, R1_RotatesByHand) {
  // yaw of a quarter turn: forward (x) points east (y); pitch of a quarter: forward points up (-z); roll of a quarter: starboard points
  // down
  EXPECT_NEAR((rotation_from_rpy({0, 0, kPi / 2}) * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0.0, kRounding);
  EXPECT_NEAR((rotation_from_rpy({0, kPi / 2, 0}) * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(), 0.0, kRounding);
  EXPECT_NEAR((rotation_from_rpy({kPi / 2, 0, 0}) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 0.0, kRounding);
}

TEST(Se3, R2_AnglesOfARotation) {
  Rng rng(31);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Eigen::Vector3d rpy = random_rpy(rng, point);
    const Eigen::Vector3d back = rpy_from_rotation(rotation_from_rpy(rpy));
    for (Eigen::Index i = 0; i < 3; ++i) EXPECT_NEAR(angle_difference(back(i), rpy(i)), 0.0, 1e-11);
  }
}

TEST(Se3, R2_R4_VerticalPitchIsRefusedWithItsValue) {
  for (const double pitch : {kPi / 2, -kPi / 2, kPi / 2 - 1e-4}) {
    EXPECT_THROW((void)rpy_from_rotation(rotation_from_rpy({0.3, pitch, 0.2})), InvalidArgument);
    EXPECT_THROW((void)euler_rates_jacobian({0.3, pitch, 0.2}, {0.1, 0.1, 0.1}), InvalidArgument);
    try {
      (void)inverse_euler_rate_matrix({0.3, pitch, 0.2});
      FAIL() << "pitch " << pitch << " was taken";
    } catch (const InvalidArgument& error) {
      EXPECT_NE(std::string(error.what()).find("pitch in degrees"), std::string::npos) << error.what();
    }
  }
  EXPECT_NO_THROW((void)inverse_euler_rate_matrix({0.3, kPi / 2 - 2e-3, 0.2}));
}

TEST(Se3, R3_RotationJacobians) {
  Rng rng(32);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Eigen::Vector3d rpy = random_rpy(rng, point);
    const Eigen::Vector3d v = random_vector(rng, 20.0);
    const auto forward = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d { return rotation_from_rpy(a) * v; };
    const auto backward = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d { return rotation_from_rpy(a).transpose() * v; };
    EXPECT_TRUE(jacobians_agree(rotate_jacobian(rpy, v), numeric_jacobian(forward, rpy)));
    EXPECT_TRUE(jacobians_agree(inverse_rotate_jacobian(rpy, v), numeric_jacobian(backward, rpy)));
  }
}

TEST(Se3, R4_EulerRatesAreTheDerivativeOfTheRotation) {
  // R(t + dt) = R(t) Exp(w dt): the rates of the angles times E are w
  Rng rng(33);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Eigen::Vector3d rpy = random_rpy(rng, point);
    const auto turned = [&](const Eigen::Vector3d& small) {
      Vector6d twist;
      twist << Eigen::Vector3d::Zero(), small;
      return rpy_from_rotation(rotation_from_rpy(rpy) * se3_exp(twist).rotation());
    };
    const Eigen::Matrix3d rates = numeric_jacobian(turned, Eigen::Vector3d(Eigen::Vector3d::Zero()), {0, 1, 2});
    EXPECT_TRUE(jacobians_agree(inverse_euler_rate_matrix(rpy), rates));
    EXPECT_NEAR((euler_rate_matrix(rpy) * inverse_euler_rate_matrix(rpy) - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-11);
  }
}

TEST(Se3, R5_EulerRateJacobian) {
  Rng rng(34);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Eigen::Vector3d rpy = random_rpy(rng, point);
    const Eigen::Vector3d w = random_vector(rng, 1.0);
    const auto rates = [&](const Eigen::Vector3d& a) -> Eigen::Vector3d { return inverse_euler_rate_matrix(a) * w; };
    EXPECT_TRUE(jacobians_agree(euler_rates_jacobian(rpy, w), numeric_jacobian(rates, rpy)));
  }
}

TEST(Se3, R6_R7_CompositionAndInverseJacobians) {
  Rng rng(35);
  int checked = 0;
  for (int point = 0; checked < kJacobianPoints; ++point) {
    const Se3 a = random_pose3(rng, point);
    const Se3 b = random_pose3(rng, point + 1);
    if (is_steep(a * b) || is_steep(a.inverse())) continue;
    ++checked;
    const auto by_left = [&](const Vector6d& v) { return (Se3::from_vector(v) * b).vector(); };
    const auto by_right = [&](const Vector6d& v) { return (a * Se3::from_vector(v)).vector(); };
    const auto inverse = [](const Vector6d& v) { return Se3::from_vector(v).inverse().vector(); };
    EXPECT_TRUE(jacobians_agree(compose_jacobian_left(a, b), numeric_jacobian(by_left, a.vector(), {3, 4, 5})));
    EXPECT_TRUE(jacobians_agree(compose_jacobian_right(a, b), numeric_jacobian(by_right, b.vector(), {3, 4, 5})));
    EXPECT_TRUE(jacobians_agree(inverse_jacobian(a), numeric_jacobian(inverse, a.vector(), {3, 4, 5})));
    EXPECT_NEAR((a * a.inverse()).vector().norm(), 0.0, 1e-11);
    EXPECT_NEAR(((a * b) * Eigen::Vector3d(1, 2, 3) - a * (b * Eigen::Vector3d(1, 2, 3))).norm(), 0.0, 1e-11);
  }
}

TEST(Se3, R8_ActionJacobians) {
  Rng rng(36);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se3 a = random_pose3(rng, point);
    const Eigen::Vector3d p = random_vector(rng, 20.0);
    const auto act = [&](const Vector6d& v) -> Eigen::Vector3d { return Se3::from_vector(v) * p; };
    const auto inverse_act = [&](const Vector6d& v) -> Eigen::Vector3d {
      const Se3 pose = Se3::from_vector(v);
      return pose.rotation().transpose() * (p - pose.translation);
    };
    EXPECT_TRUE(jacobians_agree(act_jacobian(a, p), numeric_jacobian(act, a.vector())));
    EXPECT_TRUE(jacobians_agree(inverse_act_jacobian(a, p), numeric_jacobian(inverse_act, a.vector())));
  }
}

TEST(Se3, R9_ExponentialOfAQuarterTurnIsAnArc) {
  const double r = 3.0;
  Vector6d twist;
  twist << r * kPi / 2, 0, 0.5, 0, 0, kPi / 2;  // a quarter of a helix about z
  const Se3 end = se3_exp(twist);
  EXPECT_NEAR((end.translation - Eigen::Vector3d(r, r, 0.5)).norm(), 0.0, kRounding);
  EXPECT_NEAR((end.rpy - Eigen::Vector3d(0, 0, kPi / 2)).norm(), 0.0, kRounding);
}

TEST(Se3, R9_LogarithmUndoesTheExponential) {
  Rng rng(37);
  int checked = 0;
  for (int point = 0; checked < kJacobianPoints; ++point) {
    const double angle = point % 3 == 0 ? rng.uniform(0.0, 2e-2) : point % 3 == 1 ? rng.uniform(2.6, 3.13) : rng.uniform(0.0, 3.1);
    const Eigen::Vector3d axis = random_vector(rng, 1.0).normalized();
    Vector6d twist;
    twist << random_vector(rng, 10.0), angle * axis;
    const Se3 pose = se3_exp(twist);
    if (is_steep(pose)) continue;
    ++checked;
    EXPECT_NEAR((se3_log(pose) - twist).norm(), 0.0, 1e-9) << "angle " << angle;
  }
}

TEST(Se3, R10_AdjointMovesATwistThroughAPose) {
  Rng rng(38);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se3 T = random_pose3(rng, point);
    Vector6d xi;
    xi << random_vector(rng, 1.0), random_vector(rng, 0.5);
    const auto homogeneous = [](const Se3& pose) {
      Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
      M.topLeftCorner<3, 3>() = pose.rotation();
      M.topRightCorner<3, 1>() = pose.translation;
      return M;
    };
    const Vector6d moved = adjoint(T) * xi;
    const Eigen::Matrix4d expected =
        homogeneous(T) * homogeneous(se3_exp(xi)) *
        (Eigen::Matrix4d() << T.rotation().transpose(), -T.rotation().transpose() * T.translation, Eigen::RowVector4d::UnitW()).finished();
    EXPECT_NEAR((homogeneous(se3_exp(moved)) - expected).norm(), 0.0, 1e-10);
  }
}

}  // namespace
}  // namespace ssjs
