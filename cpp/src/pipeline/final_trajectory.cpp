#include "ssjs/pipeline/final_trajectory.hpp"

namespace ssjs {

GaussianSe2 between_borders(const SubmapStep& step, const Se2& global_T_base, const RelativePose& exit, const Eigen::Vector3d& shift,
                            const Matrix6d& P) {
  const Eigen::Matrix3d J_right = compose_jacobian_right(global_T_base);
  const Se2 base_T_vehicle = additive_step(step.base_T_vehicle, step.exit_gain * shift);  // (C-5)
  Eigen::Matrix<double, 3, 6> J;
  J << compose_jacobian_left(global_T_base, base_T_vehicle) + J_right * step.exit_gain * exit.J_i, J_right * step.exit_gain * exit.J_j;
  const Eigen::Matrix3d covariance = J * P * J.transpose() + J_right * step.conditional_covariance * J_right.transpose();
  return {global_T_base * base_T_vehicle, 0.5 * (covariance + covariance.transpose())};
}

std::vector<TrajectoryPoint> final_trajectory(const std::vector<Submap>& submaps, const WorldEstimate& world) {
  std::vector<TrajectoryPoint> trajectory;
  for (const Submap& submap : submaps) {
    if (submap.steps_are_global) {
      for (const SubmapStep& step : submap.steps) trajectory.push_back({step.time_s, {step.base_T_vehicle, step.covariance}});
      continue;
    }
    const auto k = static_cast<std::size_t>(submap.index);
    const Se2& global_T_base = world.global_T_base[k];
    const RelativePose exit = relative_pose(global_T_base, world.global_T_base[k + 1]);
    const Eigen::Vector3d shift = additive_difference(exit.i_T_j, submap.state.vehicle().mean);
    for (const SubmapStep& step : submap.steps) {
      trajectory.push_back({step.time_s, between_borders(step, global_T_base, exit, shift, world.border_covariance[k])});
    }
  }
  return trajectory;
}

}  // namespace ssjs
