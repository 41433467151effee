/// Which landmarks of one levelled map others have seen already. docs/math/ports.md (P-10..P-12).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/joining/port_level.hpp"

namespace ssjs {

/// A landmark as one map knows it.
struct Sighting {
  const PortMap* map;
  Eigen::Index landmark;

  [[nodiscard]] const MapLandmark& known() const { return map->submap.landmarks[static_cast<std::size_t>(landmark)]; }
  [[nodiscard]] Eigen::Index row() const { return map->submap.landmark_offset(landmark); }
  [[nodiscard]] std::optional<Unknown> port() const { return map->unknown_at(row()); }
};

/// What a camera saw is nothing that a sonar sees, and two landmarks that look different are not one. (I-15)
[[nodiscard]] bool may_be_one(const Sighting& a, const Sighting& b, double max_descriptor_distance);

/// Landmarks in the world: position = mean + J dX + n, n ~ N(0, noise), 3 rows each; sightings of one map follow each other. (P-10)
struct PlacedSightings {
  Eigen::VectorXd mean;
  Eigen::MatrixXd J;  ///< over the unknowns given
  Eigen::MatrixXd noise;
};
/// All unknowns that the world positions of these depend on, ascending.
[[nodiscard]] std::vector<Unknown> unknowns_of(const std::vector<Sighting>& sightings);
[[nodiscard]] PlacedSightings place_sightings(const std::vector<Sighting>& sightings, const std::vector<Unknown>& unknowns,
                                              const PortValues& values);

struct PortAssociationConfig {
  JointCompatibilityConfig joint;
  double max_chance_odds = 0.3;                 ///< see associate_sightings
  std::optional<double> max_chance_alignments;  ///< the same
  double max_descriptor_distance = 0.35;
};

struct SightingPairs {
  std::vector<Pair> pairs;              ///< observation = place in `observed`, prediction = place in `predicted`; ascending
  double joint_squared_distance = 0.0;  ///< of the pairs, 2 degrees of freedom each
  double sigma_m = 0.0;                 ///< largest standard deviation of a pair's displacement by the unknowns, before the pairing
  int refused = 0;                      ///< jointly compatible pairs that chance explains too well, one by one or together
  bool budget_exhausted = false;
};

/// `observed` are of one map. Joint compatibility in the plane over pairs whose depths agree (gate_probability, 1 degree of freedom), with
/// the joint covariance of both sides, in which the compass offsets already tell how the maps are turned against each other. Then pairs
/// are dropped, the worst first, while the odds that a pair, given all others, is a foreign landmark that happens to lie there exceed
/// max_chance_odds: a lone pair in a crowd, or under an uncertain track, means nothing.
/// With max_chance_alignments the pairs that would move the maps against each other are refused, all of them, when so many alignments as
/// good are to be expected by chance (W-5).
/// density_per_m2: landmarks to be met by chance. Where landmarks have descriptors, pairs that look different are refused, and of the
/// landmarks met by chance only that part counts which looks alike (I-15).
[[nodiscard]] SightingPairs associate_sightings(const std::vector<Sighting>& observed, const std::vector<Sighting>& predicted,
                                                const PortLevel& level, double density_per_m2, const PortAssociationConfig& config);

}  // namespace ssjs
