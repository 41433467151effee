/// Which live maps might overlap a new one, and what their landmarks look like to each other. docs/math/ssjs.md (J-6, J-7).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/joining/conditional_map.hpp"
#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/live_map.hpp"

namespace ssjs {

/// How surely two maps are placed to each other, without looking at their landmarks.
struct RelativePlacement {
  double gap_m = 0.0;    ///< distance of the landmark circles' rims; negative when they overlap
  double sigma_m = 0.0;  ///< largest standard deviation of the displacement of b's centroid in a's frame
};
[[nodiscard]] RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GlobalMap& global);
/// The same with a joint covariance of the bases (a, b) given.
[[nodiscard]] RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GlobalMap& global, const Matrix6d& P_bases);

/// Landmarks of both maps that can meet, in a's frame: `problem.predicted` those of a, `problem.observed` those of b, with the
/// joint covariance that includes everything the bases have in common (J-7).
struct Encounter {
  PairingProblem problem;
  std::vector<Eigen::Index> a_landmarks, b_landmarks;  ///< rows of the problem -> landmarks of the maps
  std::vector<int> bases;                              ///< involved
  Eigen::MatrixXd J_a, J_b;                            ///< d(predicted), d(observed) / d bases
  Eigen::MatrixXd noise_a, noise_b;                    ///< conditional covariances given the bases
  Eigen::MatrixXd P_bases;
};
/// reach_m: how far a landmark may lie outside the other map's circle and still be looked at.
[[nodiscard]] Encounter encounter(const LiveMap& a, const LiveMap& b, const GlobalMap& global, double reach_m);
/// Of paired landmarks alone (row i: pair i), where no pairing is to be sought: the problem's covariances stay empty.
[[nodiscard]] Encounter encounter(const LiveMap& a, const LiveMap& b, const GlobalMap& global, const std::vector<Pair>& landmark_pairs);

/// Largest standard deviation, over the pairs, of the predicted displacement that the bases leave open (the ambiguity of the pairing).
[[nodiscard]] double displacement_sigma(const Encounter& meeting, const std::vector<Pair>& pairs);

/// (J-13) for the pairs of the encounter.
[[nodiscard]] JoinEvidence evidence_of(const Encounter& meeting, const std::vector<Pair>& pairs);

/// Pairs of the problem's rows -> pairs of the maps' landmarks.
[[nodiscard]] std::vector<Pair> landmark_pairs(const Encounter& meeting, const std::vector<Pair>& pairs);

}  // namespace ssjs
