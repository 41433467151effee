#include "ssjs/joining/conditional_map.hpp"

namespace ssjs {
namespace {

std::vector<int> base_and_ports(const LiveMap& map) {
  std::vector<int> bases{map.base};
  bases.insert(bases.end(), map.poses.begin(), map.poses.begin() + map.ports);
  return bases;
}

}  // namespace

ConditionalMap condition_on_ports(const LiveMap& map, const GlobalMap& global) {
  ConditionalMap result{base_and_ports(map), map.mean.tail(map.mean.size() - map.port_size()), {}};
  const Eigen::Index m = result.mean.size();
  const Eigen::Index internal = map.pose_count() - map.ports;
  result.J.setZero(m, 3 * (map.ports + 1));
  Eigen::VectorXd shift(map.port_size());
  for (Eigen::Index i = 0; i < map.ports; ++i) {
    const RelativePose relative = relative_pose(global.pose(map.base), global.pose(map.poses[static_cast<std::size_t>(i)]));
    shift.segment<3>(3 * i) = additive_difference(relative.i_T_j, map.base_T_pose(i));
    const auto K_port = map.K.middleCols<3>(3 * i);
    result.J.leftCols<3>().noalias() += K_port * relative.J_i;
    result.J.middleCols<3>(3 * (i + 1)).noalias() = K_port * relative.J_j;
  }
  result.mean.noalias() += map.K * shift;  // (J-3)
  for (Eigen::Index i = 0; i < internal; ++i) result.mean(3 * i + 2) = wrap_angle(result.mean(3 * i + 2));
  return result;
}

WorldMap to_world(const LiveMap& map, const GlobalMap& global) {
  const ConditionalMap local = condition_on_ports(map, global);
  const Se2& global_T_base = global.pose(map.base);
  const Eigen::Matrix2d R = global_T_base.rotation();
  const Eigen::Matrix3d J_right = compose_jacobian_right(global_T_base);
  const Eigen::Index internal = map.pose_count() - map.ports;
  const Eigen::Index u = local.J.cols();
  const Eigen::MatrixXd P = global.covariance(local.bases);

  WorldMap world;
  world.bases = local.bases;
  world.J_poses.setZero(3 * map.pose_count(), u);
  world.pose_noise.setZero(3 * map.pose_count(), 3 * map.pose_count());
  for (Eigen::Index i = 0; i < map.ports; ++i) {
    world.global_T_pose.push_back(global.pose(map.poses[static_cast<std::size_t>(i)]));
    world.J_poses.block<3, 3>(3 * i, 3 * (i + 1)).setIdentity();
  }
  const Eigen::MatrixXd C = map.conditional_covariance();
  for (Eigen::Index i = 0; i < internal; ++i) {
    const Se2 base_T_pose = Se2::from_vector(local.mean.segment<3>(3 * i));
    const Eigen::Index row = 3 * (map.ports + i);
    world.global_T_pose.push_back(global_T_base * base_T_pose);
    world.J_poses.middleRows<3>(row) = J_right * local.J.middleRows<3>(3 * i);
    world.J_poses.block<3, 3>(row, 0) += compose_jacobian_left(global_T_base, base_T_pose);
    for (Eigen::Index j = 0; j < internal; ++j) {
      world.pose_noise.block<3, 3>(row, 3 * (map.ports + j)) = J_right * C.block<3, 3>(3 * i, 3 * j) * J_right.transpose();
    }
  }
  const Eigen::Index n = map.landmark_count();
  world.landmarks.resize(2, n);
  world.landmark_covariance.reserve(static_cast<std::size_t>(n));
  Eigen::MatrixXd J(2, u);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index at = 3 * internal + 2 * i;
    const Eigen::Vector2d base_p = local.mean.segment<2>(at);
    world.landmarks.col(i) = global_T_base * base_p;
    J.noalias() = R * local.J.middleRows<2>(at);
    J.leftCols<3>() += act_jacobian(global_T_base, base_p);
    world.landmark_covariance.push_back(J * P * J.transpose() + R * C.block<2, 2>(at, at) * R.transpose());  // (J-17)
  }
  return world;
}

}  // namespace ssjs
