#include "ssjs/joining/map_association.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/association/randomized_joint_compatibility.hpp"

namespace ssjs {

namespace {

constexpr Eigen::Index kTaken = std::numeric_limits<Eigen::Index>::max();

}  // namespace

std::vector<Pair> pair_by_identity(const LiveMap& a, const LiveMap& b) {
  std::vector<std::pair<std::int64_t, Eigen::Index>> in_a;  // sorted; of the same identity twice the first counts
  in_a.reserve(a.landmarks.size());
  for (Eigen::Index i = 0; i < a.landmark_count(); ++i) {
    const auto& id = a.landmarks[static_cast<std::size_t>(i)].source_id;
    if (id) in_a.emplace_back(*id, i);
  }
  std::sort(in_a.begin(), in_a.end());
  std::vector<Pair> pairs;
  for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
    const auto& id = b.landmarks[static_cast<std::size_t>(i)].source_id;
    if (!id) continue;
    const auto found = std::lower_bound(in_a.begin(), in_a.end(), std::pair{*id, Eigen::Index{0}});
    if (found == in_a.end() || found->first != *id || found->second == kTaken) continue;
    pairs.push_back({i, found->second});
    found->second = kTaken;
  }
  return pairs;
}

std::optional<int> count_wrong_pairs(const std::vector<Pair>& pairs, const LiveMap& a, const LiveMap& b) {
  int wrong = 0;
  for (const Pair& pair : pairs) {
    const auto& id_a = a.landmarks[static_cast<std::size_t>(pair.prediction)].source_id;
    const auto& id_b = b.landmarks[static_cast<std::size_t>(pair.observation)].source_id;
    if (!id_a || !id_b) return std::nullopt;
    wrong += *id_a != *id_b ? 1 : 0;
  }
  return wrong;
}

MapAssociator::MapAssociator(const MapAssociationConfig& config, std::uint64_t seed)
    : config_(config), rng_(Rng(seed).stream("map association")) {}

std::optional<double> MapAssociator::ambiguity_gate() const { return identities_are_known() ? std::nullopt : config_.max_pairing_sigma_m; }

Hypothesis MapAssociator::associate(const PairingProblem& problem) {
  if (config_.method == AssociationMethod::kNearestNeighbour) return nearest_neighbour(problem, config_.joint.gate_probability);
  const bool is_large = config_.randomized_above && std::max(problem.observations(), problem.predictions()) > *config_.randomized_above;
  if (config_.method == AssociationMethod::kRandomizedJointCompatibility || is_large) {
    RandomizedJointCompatibilityConfig randomized;
    randomized.joint = config_.joint;
    return randomized_joint_compatibility(problem, randomized, rng_);
  }
  return associate_exactly(problem);
}

}  // namespace ssjs
