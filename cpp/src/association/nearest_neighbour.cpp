#include "ssjs/association/nearest_neighbour.hpp"

#include <algorithm>
#include <vector>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/joint_factor.hpp"

namespace ssjs {

Hypothesis nearest_neighbour(const PairingProblem& problem, double gate_probability) {
  const Compatibility compatibility = individual_compatibility(problem, joint_gates(gate_probability, 1).front());
  std::vector<Pair> candidates;
  for (Eigen::Index i = 0; i < problem.observations(); ++i) {
    for (const Eigen::Index j : compatibility.candidates[static_cast<std::size_t>(i)]) candidates.push_back({i, j});
  }
  const auto distance = [&](const Pair& pair) { return compatibility.squared_distance(pair.observation, pair.prediction); };
  std::sort(candidates.begin(), candidates.end(),
            [&](const Pair& a, const Pair& b) { return distance(a) != distance(b) ? distance(a) < distance(b) : a < b; });

  Hypothesis hypothesis;
  hypothesis.nearest_squared_distance = nearest_squared_distances(compatibility);
  std::vector<bool> observation_taken(static_cast<std::size_t>(problem.observations()), false);
  std::vector<bool> prediction_taken(static_cast<std::size_t>(problem.predictions()), false);
  for (const Pair& pair : candidates) {
    if (observation_taken[static_cast<std::size_t>(pair.observation)] || prediction_taken[static_cast<std::size_t>(pair.prediction)])
      continue;
    observation_taken[static_cast<std::size_t>(pair.observation)] = true;
    prediction_taken[static_cast<std::size_t>(pair.prediction)] = true;
    hypothesis.pairs.push_back(pair);
  }
  std::sort(hypothesis.pairs.begin(), hypothesis.pairs.end());
  hypothesis.joint_squared_distance = joint_squared_distance(problem, hypothesis.pairs);
  return hypothesis;
}

}  // namespace ssjs
