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

/// One point a step: every past pose follows the last estimate of its submap's borders (C-5), unless its steps are global already.
[[nodiscard]] std::vector<TrajectoryPoint> final_trajectory(const std::vector<Submap>& submaps, const WorldEstimate& world);

}  // namespace ssjs
