/// A map of the joining layer: one submap, or several fused into one. A factor on its own ports. docs/math/ssjs.md (J-1..J-3).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/mapping/submap.hpp"

namespace ssjs {

/// State [poses | landmarks] in the frame of `base`: poses are other base frames met inside the map, the first `ports` of them
/// those at which another map or the vehicle attaches (its ports s), the rest internal. Base k is where submap k starts.
/// Every raw measurement lives in exactly one live map, so live maps are mutually independent given their ports.
struct LiveMap {
  int base = 0;
  std::vector<int> members;  ///< submap indices, ascending
  std::vector<int> poses;    ///< base indices
  Eigen::Index ports = 0;
  std::vector<MapLandmark> landmarks;
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;

  // Conditional form (J-2): m = mean_m + K (s - mean_s) + e, e ~ N(0, C) independent of everything outside the map;
  // m is all behind the ports: internal poses, then landmarks. C = P_mm - K P_sm is computed where it is asked for.
  Eigen::MatrixXd K;
  Eigen::MatrixXd port_information;                    ///< P_ss^-1 (J-4)
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< of the landmarks
  double radius = 0.0;                                 ///< farthest landmark from the centroid

  [[nodiscard]] static auto pose(Eigen::Index index) { return Eigen::seqN(3 * index, Eigen::fix<3>); }
  [[nodiscard]] auto landmark(Eigen::Index index) const { return Eigen::seqN(landmark_offset(index), Eigen::fix<2>); }
  [[nodiscard]] Eigen::Index landmark_offset(Eigen::Index index) const { return 3 * pose_count() + 2 * index; }
  [[nodiscard]] Eigen::Index pose_count() const { return static_cast<Eigen::Index>(poses.size()); }
  [[nodiscard]] Eigen::Index landmark_count() const { return static_cast<Eigen::Index>(landmarks.size()); }
  [[nodiscard]] Eigen::Index port_size() const { return 3 * ports; }
  [[nodiscard]] Se2 base_T_pose(Eigen::Index index) const { return Se2::from_vector(mean(pose(index))); }
  [[nodiscard]] std::optional<Eigen::Index> pose_of(int base_index) const;  ///< position among `poses`
  /// C, or its rows and columns `of_m`.
  [[nodiscard]] Eigen::MatrixXd conditional_covariance() const;
  [[nodiscard]] Eigen::MatrixXd conditional_covariance(const Eigen::VectorXi& of_m) const;
};

/// The live map of a finished submap: one port, the exit pose.
[[nodiscard]] LiveMap live_map_of(const Submap& submap);

/// Marginalises the listed poses (positions among `poses`) out; ports must be set anew afterwards.
void remove_poses(LiveMap& map, const std::vector<Eigen::Index>& removed);

/// Puts the poses for which is_port holds first and computes the conditional form. Throws NotPositiveDefinite naming the map.
void set_ports(LiveMap& map, const std::vector<bool>& is_port);

}  // namespace ssjs
