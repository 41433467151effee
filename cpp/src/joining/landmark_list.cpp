#include "ssjs/joining/landmark_list.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "ssjs/joining/nearby_maps.hpp"

namespace ssjs {

std::vector<LandmarkEstimate> listed_once(const std::vector<LandmarkEstimate>& landmarks, const std::vector<SameLandmark>& same) {
  std::vector<std::size_t> group(landmarks.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto root = [&group](std::size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  for (const auto& [first, second] : same) {
    const std::size_t i = root(first);
    const std::size_t j = root(second);
    group[std::max(i, j)] = std::min(i, j);
  }
  std::map<std::size_t, LandmarkEstimate> surest;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto [place, is_first] = surest.emplace(root(i), landmarks[i]);
    if (is_first) continue;
    LandmarkEstimate& kept = place->second;
    MapLandmark together = kept.landmark;
    together.take(landmarks[i].landmark);
    if (landmarks[i].position.covariance.trace() < kept.position.covariance.trace()) {
      kept = landmarks[i];
      together.source_id = landmarks[i].landmark.source_id;
    }
    kept.landmark = std::move(together);
  }
  std::vector<LandmarkEstimate> kept;
  for (const auto& entry : surest) kept.push_back(entry.second);
  return kept;
}

std::vector<SameLandmark> common_landmarks(const std::map<int, LiveMap>& maps, const std::map<int, std::size_t>& first_of,
                                           const std::function<Se2(int)>& global_T_base,
                                           const std::function<std::vector<Pair>(const LiveMap& a, const LiveMap& b)>& paired) {
  std::vector<SameLandmark> same;
  for (auto a = maps.begin(); a != maps.end(); ++a) {
    for (auto b = std::next(a); b != maps.end(); ++b) {
      const double centres = (global_T_base(a->first) * a->second.centroid - global_T_base(b->first) * b->second.centroid).norm();
      if (centres > a->second.radius + b->second.radius + kReachMargin) continue;
      for (const Pair& pair : paired(a->second, b->second)) {
        same.emplace_back(first_of.at(a->first) + static_cast<std::size_t>(pair.prediction),
                          first_of.at(b->first) + static_cast<std::size_t>(pair.observation));
      }
    }
  }
  return same;
}

}  // namespace ssjs
