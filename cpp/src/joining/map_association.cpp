#include "ssjs/joining/map_association.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "ssjs/association/nearest_neighbour.hpp"
#include "ssjs/association/randomized_joint_compatibility.hpp"

namespace ssjs {

int common_identities(const LiveMap& a, const LiveMap& b) {
  std::set<std::int64_t> of_a;
  for (const MapLandmark& landmark : a.landmarks) {
    if (landmark.source_id) of_a.insert(*landmark.source_id);
  }
  return static_cast<int>(std::count_if(b.landmarks.begin(), b.landmarks.end(),
                                        [&](const MapLandmark& l) { return l.source_id && of_a.count(*l.source_id) != 0; }));
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

namespace {

std::vector<Eigen::Index> all_landmarks(const LiveMap& map) {
  std::vector<Eigen::Index> all(map.landmarks.size());
  std::iota(all.begin(), all.end(), Eigen::Index{0});
  return all;
}

}  // namespace

std::vector<Pair> pair_by_identity(const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks, const LiveMap& b,
                                   const std::vector<Eigen::Index>& b_landmarks) {
  std::multimap<std::int64_t, std::size_t> free;  // identity -> position in a_landmarks, ascending
  for (std::size_t j = 0; j < a_landmarks.size(); ++j) {
    const auto& id = a.landmarks[static_cast<std::size_t>(a_landmarks[j])].source_id;
    if (id) free.emplace(*id, j);
  }
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < b_landmarks.size(); ++i) {
    const auto& id = b.landmarks[static_cast<std::size_t>(b_landmarks[i])].source_id;
    if (!id) continue;
    const auto found = free.lower_bound(*id);
    if (found == free.end() || found->first != *id) continue;
    pairs.push_back({static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(found->second)});
    free.erase(found);
  }
  return pairs;
}

std::vector<Pair> landmarks_of_rows(const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& a_landmarks,
                                    const std::vector<Eigen::Index>& b_landmarks) {
  std::vector<Pair> of_maps;
  of_maps.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    of_maps.push_back({b_landmarks[static_cast<std::size_t>(pair.observation)], a_landmarks[static_cast<std::size_t>(pair.prediction)]});
  }
  return of_maps;
}

MapAssociator::MapAssociator(const MapAssociationConfig& config, std::uint64_t seed)
    : config_(config), rng_(Rng(seed).stream("map association")) {}

std::optional<double> MapAssociator::ambiguity_gate() const { return identities_are_known() ? std::nullopt : config_.max_pairing_sigma_m; }

Hypothesis MapAssociator::associate(const PairingProblem& problem, const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks,
                                    const LiveMap& b, const std::vector<Eigen::Index>& b_landmarks) {
  if (config_.method == AssociationMethod::kNearestNeighbour) return nearest_neighbour(problem, config_.joint.gate_probability);
  const bool large = config_.randomized_above && std::max(a.landmark_count(), b.landmark_count()) > *config_.randomized_above;
  if (config_.method == AssociationMethod::kRandomizedJointCompatibility ||
      (config_.method == AssociationMethod::kJointCompatibility && large)) {
    RandomizedJointCompatibilityConfig randomized;
    randomized.joint = config_.joint;
    return randomized_joint_compatibility(problem, randomized, rng_);
  }
  return associate_exactly(problem, a, a_landmarks, b, b_landmarks);
}

Hypothesis MapAssociator::associate_exactly(const PairingProblem& problem, const LiveMap& a, const std::vector<Eigen::Index>& a_landmarks,
                                            const LiveMap& b, const std::vector<Eigen::Index>& b_landmarks) const {
  if (!identities_are_known()) return joint_compatibility(problem, config_.joint);
  Hypothesis hypothesis;
  hypothesis.pairs = pair_by_identity(a, a_landmarks, b, b_landmarks);
  return hypothesis;
}

std::vector<Pair> MapAssociator::pair_all_by_identity(const LiveMap& a, const LiveMap& b) {
  return pair_by_identity(a, all_landmarks(a), b, all_landmarks(b));
}

}  // namespace ssjs
