/// A map of consecutive submaps that ends where the next map begins, and the join of two such neighbours.
/// docs/math/joining_methods.md (L-1..L-5).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "ssjs/joining/fusion.hpp"
#include "ssjs/joining/map_association.hpp"
#include "ssjs/joining/map_joiner.hpp"

namespace ssjs {

/// Where one submap begins and ends, in the frame of the map that holds it, as it was known when its first base left the state (L-4).
struct BorderEstimate {
  Se2 start, end;
  Matrix6d covariance;  ///< of both, additive coordinates
};

/// State [exit pose | landmarks]; the bases in between have left it.
struct ChainedMap {
  LiveMap map;                                  ///< one pose, the exit; no ports
  std::vector<BorderEstimate> borders;          ///< by member
  std::map<std::int64_t, int> submap_of_track;  ///< which submap saw a track of the landmarks
};
[[nodiscard]] ChainedMap chained_map_of(const Submap& submap);

/// Merges neighbours on their shared base and the pairs: fuse() or another with its contract.
using MergeNeighbours = Fusion (*)(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs);

/// b starts where a ends. Adds what happened to the report.
[[nodiscard]] ChainedMap join_neighbours(const ChainedMap& a, const ChainedMap& b, MergeNeighbours merge, MapAssociator& associator,
                                         JoinReport& report);

/// Looks for landmarks that stand in the map twice, submap after submap (L-5); nothing with known identities.
void associate_with_itself(ChainedMap& chained, MapAssociator& associator, JoinReport& report);

}  // namespace ssjs
