/// Which maps a new submap is compared with. docs/math/ssjs.md (J-6).
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/loop_candidates.hpp"

namespace ssjs {

constexpr double kReachSigmas = 3.0;  ///< of the relative placement: farther maps and landmarks are not looked at
constexpr double kReachMargin = 1.0;  ///< m, for the landmarks' own uncertainty

struct NearbyMapsConfig {
  int min_landmarks = 3;
  int min_gap = 1;                    ///< maps with a member at most so many submaps away in time are neighbours, not candidates
  std::optional<double> max_sigma_m;  ///< a less certain placement would be refused anyway
};

/// Bases of the maps within reach of the landmarks of `fresh` (a single submap), the nearest first. Poses come from `global_T_base`;
/// `placement` is asked only for maps that are not too far whatever it says.
[[nodiscard]] std::vector<int> nearby_maps(const std::map<int, LiveMap>& maps, const LiveMap& fresh, const NearbyMapsConfig& config,
                                           const std::function<Se2(int)>& global_T_base,
                                           const std::function<RelativePlacement(const LiveMap&)>& placement);

}  // namespace ssjs
