/// Landmarks of a survey that are known twice and are one object. docs/math/ports.md (P-16..P-18).
#pragma once

#include <deque>
#include <vector>

#include "ssjs/joining/port_association.hpp"
#include "ssjs/joining/port_level.hpp"

namespace ssjs {

struct DuplicateConfig {
  double gate_probability = 0.99;         ///< in the plane and in depth
  double duplicate_probability = 0.05;    ///< that a landmark is known a second time, before anything is looked at
  double max_chance_odds = 0.3;           ///< of two neighbours against one object
  double max_descriptor_distance = 0.35;  ///< of what they look like, where that is known
};

/// Two sightings that stand for different landmarks so far: ports (each by the first map that holds it) or landmarks of one map.
struct Duplicate {
  Sighting a, b;
  double squared_distance = 0.0;  ///< in the plane, 2 degrees of freedom
  double chance_odds = 0.0;
};

/// Landmarks of the maps `among` (ascending) that are likely to be one: their difference passes its gates under its own covariance (P-16),
/// the odds that they are two neighbours are small enough (P-17), and no ping ever showed both (P-18). The likeliest first; of maps that a
/// likelier pair has tied nothing more is said: once that is done, all others are to be judged anew.
[[nodiscard]] std::vector<Duplicate> likely_duplicates(const std::deque<PortMap>& maps, const std::vector<int>& among,
                                                       const PortLevel& level, const DuplicateConfig& config);

}  // namespace ssjs
