/// Which landmark of one map is which of another. docs/math/association.md, docs/math/ssjs.md (J-7).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/mapping/scan_association.hpp"

namespace ssjs {

// Pairs of landmarks: observation = landmark of b, prediction = landmark of a.

/// Landmarks of the same source identity, without looking at any covariance.
[[nodiscard]] std::vector<Pair> pair_by_identity(const LiveMap& a, const LiveMap& b);

/// How many pairs have different source identities; empty unless all are known.
[[nodiscard]] std::optional<int> count_wrong_pairs(const std::vector<Pair>& pairs, const LiveMap& a, const LiveMap& b);

struct MapAssociationConfig {
  AssociationMethod method = AssociationMethod::kJointCompatibility;
  JointCompatibilityConfig joint;
  std::optional<double> max_pairing_sigma_m;  ///< a less certain pairing is ambiguous
  std::optional<int> randomized_above;        ///< joint compatibility is randomised where more landmarks of either map can meet
};

/// The configured method on the pairing problem of two maps. With known association there is no problem to solve: pair_by_identity().
class MapAssociator {
 public:
  MapAssociator(const MapAssociationConfig& config, std::uint64_t seed);

  [[nodiscard]] bool identities_are_known() const { return config_.method == AssociationMethod::kKnown; }
  /// m; absent with known association, which cannot be ambiguous.
  [[nodiscard]] std::optional<double> ambiguity_gate() const;

  [[nodiscard]] Hypothesis associate(const PairingProblem& problem);
  /// Joint compatibility whatever the method: no draw, no change.
  [[nodiscard]] Hypothesis associate_exactly(const PairingProblem& problem) const { return joint_compatibility(problem, config_.joint); }

 private:
  MapAssociationConfig config_;
  Rng rng_;
};

}  // namespace ssjs
