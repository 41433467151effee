/// A levelled map as the methods for vehicles in the plane take it. docs/math/underwater_methods.md (U-1).
#pragma once

#include <cstdint>

#include "ssjs/mapping/levelled_submap.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

/// The marginal over the exit pose and the landmarks' x, y, in the same base frame; depths and compass offsets are marginalised out. A
/// landmark is seen times_seen times and has one track, its own: first_track + its place in the map. No steps: they stay with the levelled
/// map.
[[nodiscard]] Submap planar_submap_of(const LevelledSubmap& submap, std::int64_t first_track);

}  // namespace ssjs
