#include "ssjs/joining/conditional_map.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"

namespace ssjs {
namespace {

using testing::global_map_at;
using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_map;
using testing::random_pose;

/// A map at base 1 with ports 2 and 3, an internal pose 4 and five landmarks, in a world whose bases do not stand where the map
/// thinks: every port is off by decimetres and tenths of a radian.
struct Point {
  std::vector<Se2> bases;  ///< 1, 2, 3
  LiveMap map;

  explicit Point(Rng& rng, int point) {
    for (int k = 0; k < 3; ++k) bases.push_back(random_pose(rng, point + k));
    map = random_map(rng, 1, {2, 3, 4}, 2, 5, 0.3);
    for (Eigen::Index i = 0; i < 2; ++i) {
      const Se2 true_port = bases[0].inverse() * bases[static_cast<std::size_t>(i) + 1];
      const Eigen::Vector3d off(rng.normal(0.3), rng.normal(0.3), rng.normal(0.2));
      map.mean.segment<3>(3 * i) = additive_step(true_port, off).vector();
    }
  }
  [[nodiscard]] Eigen::VectorXd coordinates() const {
    Eigen::VectorXd x(9);
    for (Eigen::Index i = 0; i < 3; ++i) x.segment<3>(3 * i) = bases[static_cast<std::size_t>(i)].vector();
    return x;
  }
};

std::vector<Se2> poses_of(const Eigen::VectorXd& x) {
  std::vector<Se2> poses;
  for (Eigen::Index i = 0; i < x.size(); i += 3) poses.push_back(Se2::from_vector(x.segment<3>(i)));
  return poses;
}

TEST(ConditionalMap, J3_JacobianOfWhatFollowsThePorts) {
  Rng rng(411);
  for (int i = 0; i < kJacobianPoints; ++i) {
    const Point point(rng, i);
    const ConditionalMap conditional = condition_on_ports(point.map, global_map_at(point.bases));
    EXPECT_EQ(conditional.bases, (std::vector<int>{1, 2, 3}));
    const auto mean = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      return condition_on_ports(point.map, global_map_at(poses_of(x))).mean;
    };
    EXPECT_TRUE(jacobians_agree(conditional.J, numeric_jacobian(mean, point.coordinates(), {2}))) << i;
  }
}

TEST(ConditionalMap, J3_NothingMovesWhileThePortsStandWhereTheMapThinks) {
  Rng rng(412);
  Point point(rng, 0);
  for (std::size_t i = 0; i < 2; ++i) point.bases[i + 1] = point.bases[0] * point.map.base_T_pose(static_cast<Eigen::Index>(i));
  const ConditionalMap conditional = condition_on_ports(point.map, global_map_at(point.bases));
  EXPECT_LE((conditional.mean - point.map.mean.tail(13)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ConditionalMap, J3_OneDimensionByHand) {
  // Port x and landmark x with variances 4 and 9, covariance 2: K = 1/2. The port turns out 3 m farther: the landmark follows by 1.5 m.
  LiveMap map;
  map.base = 1;
  map.poses = {2};
  map.landmarks.resize(1);
  map.mean = Eigen::VectorXd::Zero(5);
  map.mean << 10.0, 0.0, 0.0, 7.0, 1.0;
  map.covariance = Eigen::MatrixXd::Identity(5, 5);
  map.covariance(0, 0) = 4.0;
  map.covariance(3, 3) = 9.0;
  map.covariance(0, 3) = map.covariance(3, 0) = 2.0;
  set_ports(map, {true});
  EXPECT_NEAR(map.K(0, 0), 0.5, 1e-12);
  EXPECT_NEAR(map.conditional_covariance()(0, 0), 9.0 - 1.0, 1e-12);
  const ConditionalMap conditional = condition_on_ports(map, global_map_at({{5.0, 5.0, 0.0}, {18.0, 5.0, 0.0}}));
  EXPECT_NEAR(conditional.mean(0), 8.5, 1e-12);
  EXPECT_NEAR(conditional.mean(1), 1.0, 1e-12);
}

TEST(ConditionalMap, J17_JacobianOfThePosesInTheWorld) {
  Rng rng(413);
  for (int i = 0; i < kJacobianPoints; ++i) {
    const Point point(rng, i);
    const WorldMap world = to_world(point.map, global_map_at(point.bases));
    const auto poses = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      const WorldMap at = to_world(point.map, global_map_at(poses_of(x)));
      Eigen::VectorXd stacked(9);
      for (Eigen::Index k = 0; k < 3; ++k) stacked.segment<3>(3 * k) = at.global_T_pose[static_cast<std::size_t>(k)].vector();
      return stacked;
    };
    EXPECT_TRUE(jacobians_agree(world.J_poses, numeric_jacobian(poses, point.coordinates(), {2, 5, 8}))) << i;
  }
}

TEST(ConditionalMap, J17_CovariancesInTheWorld) {
  Rng rng(414);
  for (int i = 0; i < 10; ++i) {
    const Point point(rng, i);
    const GlobalMap global = global_map_at(point.bases);
    const WorldMap world = to_world(point.map, global);
    const Eigen::MatrixXd P = global.covariance({1, 2, 3});
    const Eigen::Matrix2d R = point.bases[0].rotation();
    const auto landmarks = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      const Eigen::Matrix2Xd at = to_world(point.map, global_map_at(poses_of(x))).landmarks;
      return Eigen::Map<const Eigen::VectorXd>(at.data(), at.size());
    };
    const Eigen::MatrixXd J = numeric_jacobian(landmarks, point.coordinates());
    for (Eigen::Index k = 0; k < 5; ++k) {
      const Eigen::Matrix2d C = point.map.conditional_covariance().block<2, 2>(3 + 2 * k, 3 + 2 * k);  // behind the internal pose
      const Eigen::Matrix2d expected = J.middleRows<2>(2 * k) * P * J.middleRows<2>(2 * k).transpose() + R * C * R.transpose();
      EXPECT_LE((world.landmark_covariance[static_cast<std::size_t>(k)] - expected).cwiseAbs().maxCoeff(), 1e-6);
    }
    // Ports carry no noise of their own; the internal pose that of C, turned into the world.
    Eigen::Matrix3d R3 = Eigen::Matrix3d::Identity();
    R3.topLeftCorner<2, 2>() = R;
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(9, 9);
    noise.bottomRightCorner<3, 3>() = R3 * point.map.conditional_covariance().topLeftCorner<3, 3>() * R3.transpose();
    EXPECT_LE((world.pose_noise - noise).cwiseAbs().maxCoeff(), 1e-12);
  }
}

}  // namespace
}  // namespace ssjs
