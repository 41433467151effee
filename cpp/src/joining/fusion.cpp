#include "ssjs/joining/fusion.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "ssjs/joining/fused_state.hpp"

namespace ssjs {

Fusion fuse(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs) {
  const std::vector<SharedBase> shared = shared_bases(a, b);
  FusionConstraints constraints(a, b, pairs, shared);
  const std::string name = "fusion of the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
  const FusionSolution solution = solve_fusion(constraints, initial_relative_pose(a, b, pairs, shared), name);
  const FusedState fused(a, b, pairs);

  Fusion fusion;
  fusion.chi_squared = solution.chi_squared;
  fusion.dof = static_cast<int>(constraints.c.size()) - 3;
  LiveMap& map = fusion.map;
  map.base = a.base;
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), std::back_inserter(map.members));
  fused.name_contents(map);
  for (const Pair& pair : pairs) {
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(pair.prediction)];
    const MapLandmark& other = b.landmarks[static_cast<std::size_t>(pair.observation)];
    kept.take(other);
    if (!kept.source_id) kept.source_id = other.source_id;
  }
  fused.estimate(constraints, solution, map);
  return fusion;
}

}  // namespace ssjs
