/// Landmarks that stand in several maps, listed once. docs/math/ssjs.md (J-17).
#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/map_association.hpp"
#include "ssjs/joining/map_joiner.hpp"

namespace ssjs {

/// Positions in a list of landmarks that are one landmark.
using SameLandmark = std::pair<std::size_t, std::size_t>;

/// One entry for each landmark: its surest copy, with all sightings. Nothing is estimated anew. In the order of the first copies.
[[nodiscard]] std::vector<LandmarkEstimate> listed_once(const std::vector<LandmarkEstimate>& landmarks,
                                                        const std::vector<SameLandmark>& same);

/// What the maps have in common, seen from the present estimate of their bases. first_of: where the landmarks of each map start.
[[nodiscard]] std::vector<SameLandmark> common_landmarks(const std::map<int, LiveMap>& maps, const std::map<int, std::size_t>& first_of,
                                                         const GlobalMap& global, const MapAssociator& associator);

}  // namespace ssjs
