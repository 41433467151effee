/// What is inside a live map, given the present estimate of the bases: landmarks and internal poses follow their ports.
/// docs/math/ssjs.md (J-3, J-17).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/live_map.hpp"

namespace ssjs {

/// m = mean + J d[bases] + e, e ~ N(0, C of the map): the rows behind the ports (internal poses, then landmarks), in the map's own frame.
struct ConditionalMap {
  std::vector<int> bases;  ///< the map's own base first, then its ports
  Eigen::VectorXd mean;
  Eigen::MatrixXd J;  ///< 3 columns a base
};

/// (J-3)
[[nodiscard]] ConditionalMap condition_on_ports(const LiveMap& map, const GlobalMap& global);

/// The same in the world frame, with everything the map holds: all poses (as in map.poses) and all landmarks, and their joint
/// covariance J P_G J' + R C R'. (J-17)
struct WorldMap {
  std::vector<Se2> global_T_pose;
  Eigen::Matrix2Xd landmarks;
  Eigen::MatrixXd J_poses;  ///< 3 rows a pose, 3 columns per entry of bases
  std::vector<int> bases;
  Eigen::MatrixXd pose_noise;  ///< conditional covariance of the internal poses, zero for ports (world frame)
  std::vector<Eigen::Matrix2d> landmark_covariance;
};
[[nodiscard]] WorldMap to_world(const LiveMap& map, const GlobalMap& global);

}  // namespace ssjs
