/// Two maps of which one is placed in the frame of the other by an estimate of their relative pose. docs/math/joining_methods.md (L-1).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/loop_candidates.hpp"

namespace ssjs {

/// The base of map b in the frame of map a.
struct MapPlacement {
  GaussianSe2 a_T_b;
  Eigen::MatrixXd cross;  ///< Cov(state of a, a_T_b), 3 columns; empty when they are independent
};

/// Of a pose that a itself holds: the base of b, with all its correlations. Throws InvalidArgument when a does not know it.
[[nodiscard]] MapPlacement placement_inside(const LiveMap& a, int base);

/// The landmark circles, as in loop_candidates.hpp.
[[nodiscard]] RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GaussianSe2& a_T_b);

/// Landmarks of both maps that can meet, in a's frame: `problem.predicted` those of a, `problem.observed` those of b (L-1).
struct MapMeeting {
  PairingProblem problem;
  std::vector<Eigen::Index> a_landmarks, b_landmarks;  ///< rows of the problem -> landmarks of the maps
};
[[nodiscard]] MapMeeting meet(const LiveMap& a, const LiveMap& b, const MapPlacement& placement);

/// Pairs of the problem's rows -> pairs of the maps' landmarks.
[[nodiscard]] std::vector<Pair> landmark_pairs(const MapMeeting& meeting, const std::vector<Pair>& pairs);

/// Largest standard deviation of the displacement of a pair that the placement leaves open: its ambiguity. A pair of landmarks of the maps.
[[nodiscard]] double displacement_sigma(const LiveMap& a, const LiveMap& b, const MapPlacement& placement, const Pair& pair);

}  // namespace ssjs
