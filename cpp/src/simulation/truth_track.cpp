#include "ssjs/simulation/truth_track.hpp"

#include <algorithm>

namespace ssjs {

TruthAt truth_at(const std::vector<AuvTruth>& truth, double time_s) {
  const auto after =
      std::upper_bound(truth.begin() + 1, truth.end() - 1, time_s, [](double time, const AuvTruth& at) { return time < at.time_s; });
  const AuvTruth& from = *(after - 1);
  const double part = (time_s - from.time_s) / (after->time_s - from.time_s);
  return {from, Se3::from_vector(from.world_T_vehicle.vector() + part * additive_difference(after->world_T_vehicle, from.world_T_vehicle))};
}

}  // namespace ssjs
