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

/// How many source identities both maps hold, counted without looking at any covariance.
[[nodiscard]] int common_identities(const LiveMap& a, const LiveMap& b);

/// Pairs (observation: landmark of b, prediction: landmark of a) whose source identities differ; empty unless all are known.
[[nodiscard]] std::optional<int> count_wrong_pairs(const std::vector<Pair>& pairs, const LiveMap& a, const LiveMap& b);

/// Pairs of equal source identity, as positions in the two lists of landmarks.
[[nodiscard]] std::vector<Pair> pair_by_identity(const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks, const LiveMap& b,
                                                 const std::vector<Eigen::Index>& b_landmarks);

/// Positions in the two lists -> landmarks of the maps.
[[nodiscard]] std::vector<Pair> landmarks_of_rows(const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& a_landmarks,
                                                  const std::vector<Eigen::Index>& b_landmarks);

struct MapAssociationConfig {
  AssociationMethod method = AssociationMethod::kJointCompatibility;
  JointCompatibilityConfig joint;
  std::optional<double> max_pairing_sigma_m;  ///< a less certain pairing is ambiguous
  std::optional<int> randomized_above;        ///< joint compatibility is randomised where a map has more landmarks
};

class MapAssociator {
 public:
  MapAssociator(const MapAssociationConfig& config, std::uint64_t seed);

  [[nodiscard]] bool identities_are_known() const { return config_.method == AssociationMethod::kKnown; }
  /// m; absent with known association, which cannot be ambiguous.
  [[nodiscard]] std::optional<double> ambiguity_gate() const;

  /// problem: predictions are these landmarks of a, observations those of b. Pairs are positions in the two lists.
  [[nodiscard]] Hypothesis associate(const PairingProblem& problem, const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks,
                                     const LiveMap& b, const std::vector<Eigen::Index>& b_landmarks);
  /// The same without a draw: joint compatibility wherever identities are not known.
  [[nodiscard]] Hypothesis associate_exactly(const PairingProblem& problem, const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks,
                                             const LiveMap& b, const std::vector<Eigen::Index>& b_landmarks) const;
  /// All landmarks of equal source identity, wherever they are.
  [[nodiscard]] static std::vector<Pair> pair_all_by_identity(const LiveMap& a, const LiveMap& b);

 private:
  MapAssociationConfig config_;
  Rng rng_;
};

}  // namespace ssjs
