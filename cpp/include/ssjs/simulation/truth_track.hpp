/// Where a simulated vehicle truly is between two steps of its simulation.
#pragma once

#include <vector>

#include "ssjs/geometry/se3.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {

/// The last step at or before a time, and the pose at that time: all coordinates change evenly to the next step. The time must not lie
/// outside the track, which has two steps at least.
struct TruthAt {
  const AuvTruth& step;
  Se3 world_T_vehicle;
};
[[nodiscard]] TruthAt truth_at(const std::vector<AuvTruth>& truth, double time_s);

}  // namespace ssjs
