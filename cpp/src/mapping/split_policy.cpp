#include "ssjs/mapping/split_policy.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace ssjs {

std::optional<std::string> reason_to_close(const SplitSituation& situation, const SplitPolicyConfig& config) {
  const Eigen::Matrix3d& P = situation.submap_T_vehicle.covariance;
  if (!(situation.distance_m > 0.0)) return std::nullopt;  // (C-1)
  if (config.max_landmarks && situation.new_landmarks > 0 && situation.landmarks + situation.new_landmarks > *config.max_landmarks) {
    return "landmarks";
  }
  if (situation.landmarks < config.min_landmarks) return std::nullopt;
  if (config.max_sigma_xy_m) {
    const Eigen::Vector2d variances = P.topLeftCorner<2, 2>().selfadjointView<Eigen::Lower>().eigenvalues();
    if (variances.maxCoeff() > *config.max_sigma_xy_m * *config.max_sigma_xy_m) return "position uncertainty";
  }
  if (config.max_sigma_heading_rad && std::sqrt(P(2, 2)) > *config.max_sigma_heading_rad) return "heading uncertainty";
  if (config.max_distance_m && situation.distance_m > *config.max_distance_m) return "distance";
  if (config.max_duration_s && situation.duration_s > *config.max_duration_s) return "duration";
  return std::nullopt;
}

}  // namespace ssjs
