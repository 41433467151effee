#include "ssjs/joining/port_reach.hpp"

#include <algorithm>

#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

constexpr double kReachSigmas = 3.0;
constexpr double kRelinearized = 1.1;  // of a standard deviation: a bound that was taken at other linearisation points

/// Where the centroid of the newest map lies in the frame of another, with its Jacobians over both bases.
struct SeenCentroid {
  double gap_m;  ///< between what both maps may hold
  Eigen::Matrix<double, 2, 3> J_other, J_newest;
};

SeenCentroid see(const MapExtent& newest, const Se2& global_T_newest, const MapExtent& other, const Se2& global_T_other) {
  const RelativePose tau = relative_pose(global_T_other, global_T_newest);
  const Eigen::Matrix<double, 2, 3> J_tau = act_jacobian(tau.i_T_j, newest.centroid);
  const double distance_m = (tau.i_T_j * newest.centroid - other.centroid).norm();
  return {distance_m - newest.reach_m - other.reach_m, J_tau * tau.J_i, J_tau * tau.J_j};
}

}  // namespace

MapExtent extent_of(const LevelledSubmap& submap) {
  MapExtent extent;
  const Eigen::Index n = extent.landmarks = submap.landmark_count();
  for (Eigen::Index i = 0; i < n; ++i) extent.centroid += submap.mean.segment<2>(submap.landmark_offset(i)) / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Index at = submap.landmark_offset(i);
    const double sigma_m = largest_sigma(submap.covariance.block<2, 2>(at, at));
    const double distance_m = (submap.mean.segment<2>(at) - extent.centroid).norm();
    extent.radius_m = std::max(extent.radius_m, distance_m);
    extent.reach_m = std::max(extent.reach_m, distance_m + kReachSigmas * sigma_m);
  }
  return extent;
}

void PortReach::add(const MapExtent& extent, const PortKnowledge& level) {
  const auto base = static_cast<int>(extents_.size());
  extents_.push_back(extent);
  base_covariances_.emplace_back(level.covariance({{UnknownKind::kBase, base}}));
}

std::vector<int> PortReach::before(int newest, const PortKnowledge& level) const {
  std::vector<int> others;
  const MapExtent& own = extent(newest);
  if (own.landmarks == 0) return others;
  const Eigen::Matrix3d P_newest = level.covariance({{UnknownKind::kBase, newest}});
  std::vector<Unknown> bases{{UnknownKind::kBase, newest}};
  std::vector<SeenCentroid> seen;
  for (int k = 0; k < newest; ++k) {
    if (extent(k).landmarks == 0) continue;
    const SeenCentroid centroid = see(own, level.values().base(newest), extent(k), level.values().base(k));
    // (P-28): the standard deviation of a sum is at most the sum of both
    const double bound_m = largest_sigma(centroid.J_other * base_covariances_[static_cast<std::size_t>(k)] * centroid.J_other.transpose()) +
                           largest_sigma(centroid.J_newest * P_newest * centroid.J_newest.transpose());
    if (centroid.gap_m > kRelinearized * kReachSigmas * bound_m) continue;
    bases.push_back({UnknownKind::kBase, k});
    seen.push_back(centroid);
  }
  const Eigen::MatrixXd P = level.covariance(bases);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * (i + 1));
    Eigen::Matrix<double, 2, 6> J;
    J << seen[i].J_other, seen[i].J_newest;
    Matrix6d joint;
    joint << P.block<3, 3>(at, at), P.block<3, 3>(at, 0), P.block<3, 3>(0, at), P.topLeftCorner<3, 3>();
    if (seen[i].gap_m <= kReachSigmas * largest_sigma(J * joint * J.transpose())) others.push_back(bases[i + 1].index);  // (J-6)
  }
  return others;
}

}  // namespace ssjs
