#include "geometry/numeric_jacobian.hpp"

#include <cmath>
#include <limits>

namespace ssjs::testing {
namespace {

TEST(NumericJacobian, DifferentiatesPolynomialAndSine) {
  const auto f = [](const Eigen::Vector2d& x) { return Eigen::Vector3d(x(0) * x(0) * x(1), std::sin(x(1)), 7.0); };
  const Eigen::Vector2d x(3.0, -0.5);
  Eigen::Matrix<double, 3, 2> expected;
  expected << 2.0 * 3.0 * -0.5, 9.0, 0.0, std::cos(-0.5), 0.0, 0.0;
  const Eigen::Matrix<double, 3, 2> numeric = numeric_jacobian(f, x);
  EXPECT_TRUE(jacobians_agree(expected, numeric));
}

TEST(NumericJacobian, WrapsOnlyTheRowsThatAreAngles) {
  const auto f = [](const Eigen::Matrix<double, 1, 1>& x) { return Eigen::Vector2d(wrap_angle(x(0)), wrap_angle(x(0))); };
  const Eigen::Matrix<double, 1, 1> at_pi(kPi);  // the forward value is -pi, the backward one +pi
  const Eigen::Vector2d numeric = numeric_jacobian(f, at_pi, {0});
  EXPECT_NEAR(numeric(0), 1.0, 1e-6);
  EXPECT_LT(numeric(1), -1e6);
}

TEST(NumericJacobian, ComparisonRefusesWrongEntriesNanAndSizes) {
  const Eigen::Matrix2d identity = Eigen::Matrix2d::Identity();
  Eigen::Matrix2d other = identity;
  EXPECT_TRUE(jacobians_agree(identity, other));
  other(1, 0) = 2e-6;
  EXPECT_FALSE(jacobians_agree(identity, other));
  other(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(jacobians_agree(identity, other));
  EXPECT_FALSE(jacobians_agree(identity, Eigen::MatrixXd::Identity(3, 3)));
}

TEST(NumericJacobian, RandomPosesIncludeHeadingsAtBothEndsOfTheCircle) {
  Rng rng(1);
  int near_plus = 0;
  int near_minus = 0;
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    EXPECT_GE(pose.heading, -kPi);
    EXPECT_LT(pose.heading, kPi);
    if (pose.heading > kPi - 1e-3) ++near_plus;
    if (pose.heading < -kPi + 1e-3) ++near_minus;
  }
  EXPECT_GE(near_plus, 5);
  EXPECT_GE(near_minus, 5);
}

}  // namespace
}  // namespace ssjs::testing
