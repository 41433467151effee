#include "ssjs/association/randomized_joint_compatibility.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/association/compatibility.hpp"
#include "ssjs/association/joint_factor.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

void check(const RandomizedJointCompatibilityConfig& config) {
  if (config.sample_size < 1) throw InvalidArgument("sample_size", std::to_string(config.sample_size), "must be at least 1");
  if (!(config.failure_probability > 0.0 && config.failure_probability < 1.0)) {
    throw InvalidArgument("failure_probability", config.failure_probability, "must lie in (0, 1)");
  }
  if (!(config.inlier_fraction > 0.0 && config.inlier_fraction < 1.0)) {
    throw InvalidArgument("inlier_fraction", config.inlier_fraction, "must lie in (0, 1)");
  }
}

/// samples after which one without outliers was drawn with probability 1 - failure_probability.
double samples_needed(const RandomizedJointCompatibilityConfig& config, double inlier_fraction) {
  const double clean = std::pow(inlier_fraction, config.sample_size);
  return clean >= 1.0 ? 1.0 : std::ceil(std::log(config.failure_probability) / std::log1p(-clean));
}

/// Extends sample hypotheses to all observations. The workspace serves every sample.
class Completion {
 public:
  Completion(const PairingProblem& problem, const Compatibility& compatibility, std::size_t observations_with_candidates,
             const JointCompatibilityConfig& config)
      : compatibility_(compatibility),
        factor_(problem, static_cast<Eigen::Index>(observations_with_candidates)),
        row_(2, 2 * factor_.capacity()),
        gates_(joint_gates(config.joint_gate_probability, factor_.capacity())),
        gate_(joint_gates(config.gate_probability, 1).front()),
        observation_taken_(static_cast<std::size_t>(problem.observations())),
        prediction_taken_(static_cast<std::size_t>(problem.predictions())) {}

  /// the pairs of the sample, then nearest neighbours under the covariance conditioned on them, while the joint gate holds.
  void run(const std::vector<Pair>& sample) {
    while (factor_.size() > 0) factor_.pop();
    std::fill(observation_taken_.begin(), observation_taken_.end(), false);
    std::fill(prediction_taken_.begin(), prediction_taken_.end(), false);
    for (const Pair& pair : sample) accept(conditioned(pair));

    rest_.clear();
    for (std::size_t i = 0; i < compatibility_.candidates.size(); ++i) {
      for (const Eigen::Index j : compatibility_.candidates[i]) {
        const Pair pair{static_cast<Eigen::Index>(i), j};
        if (taken(pair)) continue;
        const double distance = conditioned(pair).squared_distance;
        if (distance <= gate_) rest_.emplace_back(distance, pair);
      }
    }
    std::sort(rest_.begin(), rest_.end());  // nearest first, ties by observation, then by prediction
    for (const auto& [distance, pair] : rest_) {
      if (taken(pair)) continue;
      const ConditionedPair candidate = conditioned(pair);
      const double joint_distance = factor_.squared_distance() + candidate.squared_distance;
      if (joint_distance <= gates_[static_cast<std::size_t>(factor_.size())]) accept(candidate);
    }
  }

  [[nodiscard]] std::size_t pairs() const { return static_cast<std::size_t>(factor_.size()); }
  [[nodiscard]] double squared_distance() const { return factor_.squared_distance(); }
  void copy_to(Hypothesis& hypothesis) const {
    hypothesis.pairs.clear();
    for (Eigen::Index level = 0; level < factor_.size(); ++level) hypothesis.pairs.push_back(factor_.pair(level));
    hypothesis.joint_squared_distance = factor_.squared_distance();
  }

 private:
  [[nodiscard]] bool taken(const Pair& pair) const {
    return observation_taken_[static_cast<std::size_t>(pair.observation)] || prediction_taken_[static_cast<std::size_t>(pair.prediction)];
  }

  /// On all accepted pairs; leaves the block row in row_.
  [[nodiscard]] ConditionedPair conditioned(const Pair& pair) {
    ConditionedPair candidate = factor_.start(pair);
    for (Eigen::Index level = 0; level < factor_.size(); ++level) factor_.condition(candidate, row_, level);
    return candidate;
  }

  void accept(const ConditionedPair& candidate) {
    factor_.push(candidate, row_);
    observation_taken_[static_cast<std::size_t>(candidate.pair.observation)] = true;
    prediction_taken_[static_cast<std::size_t>(candidate.pair.prediction)] = true;
  }

  const Compatibility& compatibility_;
  JointFactor factor_;
  Eigen::Matrix2Xd row_;
  std::vector<double> gates_;
  double gate_;
  std::vector<bool> observation_taken_;
  std::vector<bool> prediction_taken_;
  std::vector<std::pair<double, Pair>> rest_;
};

}  // namespace

Hypothesis randomized_joint_compatibility(const PairingProblem& problem, const RandomizedJointCompatibilityConfig& config, Rng& rng) {
  check(config);
  const Compatibility compatibility = individual_compatibility(problem, joint_gates(config.joint.gate_probability, 1).front());
  std::vector<Eigen::Index> pool;
  for (Eigen::Index i = 0; i < problem.observations(); ++i) {
    if (!compatibility.candidates[static_cast<std::size_t>(i)].empty()) pool.push_back(i);
  }
  const std::size_t b = static_cast<std::size_t>(config.sample_size);
  if (pool.size() <= b) return joint_compatibility(problem, compatibility, pool, config.joint);

  Hypothesis best;
  best.nearest_squared_distance = nearest_squared_distances(compatibility);
  Completion completion(problem, compatibility, pool.size(), config.joint);
  double samples = samples_needed(config, config.inlier_fraction);
  for (double drawn = 0.0; drawn < samples; drawn += 1.0) {
    for (std::size_t k = 0; k < b; ++k) std::swap(pool[k], pool[k + rng.below(pool.size() - k)]);
    std::vector<Eigen::Index> sample(pool.begin(), pool.begin() + static_cast<std::ptrdiff_t>(b));
    std::sort(sample.begin(), sample.end());
    const Hypothesis seed = joint_compatibility(problem, compatibility, sample, config.joint);
    best.nodes_visited += seed.nodes_visited;
    best.budget_exhausted = best.budget_exhausted || seed.budget_exhausted;
    if (seed.pairs.empty()) continue;
    completion.run(seed.pairs);
    const bool more = completion.pairs() > best.pairs.size();
    const bool nearer = completion.pairs() == best.pairs.size() && completion.squared_distance() < best.joint_squared_distance;
    if (!more && !nearer) continue;
    completion.copy_to(best);
    // What was found shows a larger inlier fraction than assumed: fewer samples are enough.
    samples = std::min(samples, samples_needed(config, static_cast<double>(best.pairs.size()) / static_cast<double>(pool.size())));
  }
  std::sort(best.pairs.begin(), best.pairs.end());
  return best;
}

}  // namespace ssjs
