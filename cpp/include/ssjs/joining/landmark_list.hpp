/// Landmarks that stand in several maps, listed once. docs/math/ssjs.md (J-17).
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/map_joiner.hpp"

namespace ssjs {

/// Positions in a list of landmarks that are one landmark.
using SameLandmark = std::pair<std::size_t, std::size_t>;

/// One entry for each landmark: its surest copy, with all sightings. Nothing is estimated anew. In the order of the first copies.
[[nodiscard]] std::vector<LandmarkEstimate> listed_once(const std::vector<LandmarkEstimate>& landmarks,
                                                        const std::vector<SameLandmark>& same);

/// What the maps have in common: `paired` is asked about all whose landmark circles overlap. first_of: where the landmarks of each map
/// start in the list.
[[nodiscard]] std::vector<SameLandmark> common_landmarks(
    const std::map<int, LiveMap>& maps, const std::map<int, std::size_t>& first_of, const std::function<Se2(int)>& global_T_base,
    const std::function<std::vector<Pair>(const LiveMap& a, const LiveMap& b)>& paired);

}  // namespace ssjs
