#include "ssjs/joining/port_map.hpp"

#include <gtest/gtest.h>

#include "geometry/numeric_jacobian.hpp"
#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::numeric_jacobian;

/// One port of each kind, seen from base 0; unknowns stacked as in PortPlacement::J.
const std::vector<Port> kPorts{{0, {UnknownKind::kBase, 1}}, {3, {UnknownKind::kOffset, 0}}, {4, {UnknownKind::kLandmark, 0}}};

PortValues values_of(const Eigen::Matrix<double, 10, 1>& y) {
  return {{Se2{y(0), y(1), y(2)}, Se2{y(3), y(4), y(5)}}, {y(6)}, {Eigen::Vector3d(y.tail<3>())}};
}

TEST(PortMap, P3_JacobiansMatchCentralDifferences) {
  Rng rng(1);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    Eigen::Matrix<double, 10, 1> y;
    y << testing::random_pose(rng, point).vector(), testing::random_pose(rng, point + 1).vector(), rng.uniform(-kPi, kPi),
        rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0), rng.uniform(0.0, 20.0);
    const auto s = [](const Eigen::Matrix<double, 10, 1>& at) -> Eigen::Matrix<double, 7, 1> {
      return place_ports(0, kPorts, values_of(at)).s;
    };
    EXPECT_TRUE(jacobians_agree(place_ports(0, kPorts, values_of(y)).J, numeric_jacobian(s, y, {2, 3})));
  }
}

TEST(PortMap, P2_APointMovesToTheWorldAndBack) {
  Rng rng(2);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    const Se2 base = testing::random_pose(rng, point);
    const Eigen::Vector3d base_p(rng.uniform(-30.0, 30.0), rng.uniform(-30.0, 30.0), rng.uniform(0.0, 20.0));
    const WorldPoint world = to_world(base, base_p);
    const auto move = [](const Eigen::Matrix<double, 6, 1>& y) -> Eigen::Vector3d {
      return to_world(Se2::from_vector(y.head<3>()), y.tail<3>()).position;
    };
    Eigen::Matrix<double, 6, 1> y;
    y << base.vector(), base_p;
    const Eigen::Matrix<double, 3, 6> J = numeric_jacobian(move, y);
    EXPECT_TRUE(jacobians_agree(world.J_base, Eigen::Matrix3d(J.leftCols<3>())));
    EXPECT_TRUE(jacobians_agree(world.J_point, Eigen::Matrix3d(J.rightCols<3>())));
    const PortValues values{{base}, {}, {world.position}};
    EXPECT_LT((place_ports(0, {{0, {UnknownKind::kLandmark, 0}}}, values).s - base_p).norm(), 1e-12);
  }
}

TEST(PortMap, P5_RowsFollowTheirPortsWithTheirConditionalCovariance) {
  Rng rng(3);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const Eigen::MatrixXd P = testing::map_covariance({}, CompassPorts::kBorders, 2, rng);
  PortMap map{testing::noisy_levelled_submap(world, 0, {0, 1}, CompassPorts::kBorders, P, rng), {}};
  map.ports = {{0, {UnknownKind::kBase, 1}}, {3, {UnknownKind::kOffset, 0}}, {4, {UnknownKind::kOffset, 1}}};
  const Eigen::VectorXi landmarks = Eigen::VectorXi::LinSpaced(6, 5, 10);
  const ConditionalPlacement placed = place_rows(map, landmarks, world.values());
  // by the information matrix: conditioning is taking the landmarks' block of P^-1
  const Eigen::MatrixXd W = P.inverse();
  const Eigen::MatrixXd C = W.bottomRightCorner(6, 6).inverse();
  const Eigen::VectorXd s = place_ports(0, map.ports, world.values()).s;
  const Eigen::VectorXd mean =
      map.submap.mean.tail(6) - C * W.bottomLeftCorner(6, 5) * port_difference(map.ports, s, map.submap.mean.head(5));
  EXPECT_LT((placed.noise - C).norm(), 1e-12);
  EXPECT_LT((placed.mean - mean).norm(), 1e-10);
  // a port follows itself exactly
  const ConditionalPlacement itself = place_rows(map, state_rows(map.ports), world.values());
  EXPECT_LT(port_difference(map.ports, itself.mean, s).norm(), 1e-10);
  EXPECT_LT(itself.noise.norm(), 1e-10);
}

TEST(PortMap, P5_AMapWithoutPortsIsItself) {
  Rng rng(4);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const Eigen::MatrixXd P = testing::map_covariance({}, CompassPorts::kNone, 1, rng);
  const PortMap map{testing::noisy_levelled_submap(world, 0, {3}, CompassPorts::kNone, P, rng), {}};
  const ConditionalPlacement placed = place_rows(map, Eigen::Vector3i(3, 4, 5), world.values());
  EXPECT_EQ(placed.mean, Eigen::VectorXd(map.submap.mean.tail(3)));
  EXPECT_EQ(placed.noise, P.bottomRightCorner(3, 3));
}

TEST(PortMap, AnExactMapIsNamed) {
  Rng rng(5);
  const testing::LevelledWorld world = testing::survey_world(rng);
  Eigen::MatrixXd P = testing::map_covariance({}, CompassPorts::kNone, 1, rng);
  PortMap map{testing::noisy_levelled_submap(world, 0, {3}, CompassPorts::kNone, P, rng), {{0, {UnknownKind::kBase, 1}}}};
  map.submap.covariance.row(1).setZero();
  map.submap.covariance.col(1).setZero();
  try {
    static_cast<void>(condition_on_ports(map, Eigen::Vector3i(3, 4, 5)));
    FAIL() << "an exact exit was taken";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_NE(std::string(error.what()).find("map 0"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ssjs
