/// The trajectory after the mission. docs/math/submaps.md (C-5).
#pragma once

#include <vector>

#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

struct TrajectoryPoint {
  double time_s = 0.0;
  GaussianSe2 global_T_vehicle;
};

/// A past pose between two borders, (C-5). exit: the second border seen from the first; shift: exit minus where the step takes it to be;
/// P: joint covariance of the borders.
[[nodiscard]] GaussianSe2 between_borders(const SubmapStep& step, const Se2& global_T_base, const RelativePose& exit,
                                          const Eigen::Vector3d& shift, const Matrix6d& P);

/// One point a step: every past pose follows the last estimate of its submap's borders (C-5), unless its steps are global already.
[[nodiscard]] std::vector<TrajectoryPoint> final_trajectory(const std::vector<Submap>& submaps, const WorldEstimate& world);

}  // namespace ssjs
