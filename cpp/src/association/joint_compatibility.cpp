#include "ssjs/association/joint_compatibility.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>

#include "ssjs/association/joint_factor.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// A pair that may still be accepted below the current node.
struct Candidate {
  ConditionedPair conditioned;  ///< on all pairs of the current node
  Eigen::Index row;             ///< of its block row in the workspace
};

/// Depth-first branch and bound. A node is a set of accepted pairs (the factor) and the candidates still open below it,
/// grouped by observation. Lists of deeper nodes lie behind those of shallower ones in one stack.
class Search {
 public:
  Search(const PairingProblem& problem, const Compatibility& compatibility, const std::vector<Eigen::Index>& observations,
         const JointCompatibilityConfig& config)
      : order_(search_order(compatibility, observations)),
        depth_(static_cast<Eigen::Index>(order_.size())),
        factor_(problem, depth_),
        gates_(joint_gates(config.joint_gate_probability, depth_)),
        node_budget_(config.node_budget) {
    // A candidate of the h-th observation is in the lists of at most h + 1 nodes at once. Left uninitialised: pages that
    // the search never reaches cost nothing.
    std::size_t candidates = 0;
    std::size_t listed = 0;
    for (std::size_t h = 0; h < order_.size(); ++h) {
      const std::size_t count = compatibility.candidates[static_cast<std::size_t>(order_[h])].size();
      candidates += count;
      listed += count * (h + 1);
    }
    rows_.resize(2, 2 * depth_ * static_cast<Eigen::Index>(candidates));
    stack_.reset(new Candidate[listed]);
    best_pairs_.reserve(order_.size());

    Candidate* end = stack_.get();
    for (const Eigen::Index i : order_) {
      for (const Eigen::Index j : compatibility.candidates[static_cast<std::size_t>(i)]) {
        *end = {factor_.start({i, j}), end - stack_.get()};
        ++end;
      }
    }
    // First every set on the way has to pass the joint gate of its own size, as in [neira2001]: that finds a good answer soon,
    // but which one depends on the order. Where it cut anything, a second search without it starts from that answer as bound.
    gate_every_set_ = true;
    explore(stack_.get(), end);
    gate_every_set_ = false;
    if (gated_on_the_way_ && !budget_exhausted_) explore(stack_.get(), end);
  }

  [[nodiscard]] Hypothesis result() const {
    Hypothesis hypothesis;
    hypothesis.pairs = best_pairs_;
    std::sort(hypothesis.pairs.begin(), hypothesis.pairs.end());
    hypothesis.joint_squared_distance = best_squared_distance_;
    hypothesis.nodes_visited = nodes_visited_;
    hypothesis.budget_exhausted = budget_exhausted_;
    return hypothesis;
  }

 private:
  /// Observations with candidates: fewest candidates first, then nearest first, then by number.
  static std::vector<Eigen::Index> search_order(const Compatibility& compatibility, const std::vector<Eigen::Index>& observations) {
    const auto candidates = [&](Eigen::Index i) -> const std::vector<Eigen::Index>& {
      return compatibility.candidates[static_cast<std::size_t>(i)];
    };
    const auto nearest = [&](Eigen::Index i) { return compatibility.squared_distance(i, candidates(i).front()); };
    std::vector<Eigen::Index> order;
    order.reserve(observations.size());
    for (const Eigen::Index i : observations) {
      if (!candidates(i).empty()) order.push_back(i);
    }
    std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
      if (candidates(a).size() != candidates(b).size()) return candidates(a).size() < candidates(b).size();
      if (nearest(a) != nearest(b)) return nearest(a) < nearest(b);
      return a < b;
    });
    return order;
  }

  [[nodiscard]] bool passes_gate(Eigen::Index pairs, double squared_distance) const {
    return squared_distance <= gates_[static_cast<std::size_t>(pairs - 1)];
  }

  /// Whether a set of so many pairs at this joint distance would replace the best one. With the most pairs that a branch can
  /// still reach and the distance it has already, it is the bound: distance and gate only grow as pairs are added.
  [[nodiscard]] bool can_win(Eigen::Index pairs, double squared_distance) const {
    const Eigen::Index best = static_cast<Eigen::Index>(best_pairs_.size());
    if (pairs == best) return squared_distance < best_squared_distance_;
    return pairs > best && passes_gate(pairs, squared_distance);
  }

  void keep_if_better() {
    if (!can_win(factor_.size(), factor_.squared_distance())) return;
    best_squared_distance_ = factor_.squared_distance();
    best_pairs_.clear();
    for (Eigen::Index level = 0; level < factor_.size(); ++level) best_pairs_.push_back(factor_.pair(level));
  }

  [[nodiscard]] BlockRow row_of(const Candidate& candidate) { return rows_.middleCols(2 * depth_ * candidate.row, 2 * depth_); }

  /// Extends the factor by every promising choice among the open candidates [begin, end).
  void explore(Candidate* begin, Candidate* end) {
    Eigen::Index open = 0;  // observations that have a candidate left
    for (const Candidate* c = begin; c != end; ++c) {
      open += c == begin || c->conditioned.pair.observation != c[-1].conditioned.pair.observation;
    }
    for (; begin != end; --open) {
      const Eigen::Index reachable = factor_.size() + open;
      if (!can_win(reachable, factor_.squared_distance())) return;
      Candidate* group_end = begin;
      while (group_end != end && group_end->conditioned.pair.observation == begin->conditioned.pair.observation) ++group_end;
      std::sort(begin, group_end, [](const Candidate& a, const Candidate& b) {
        const ConditionedPair& ca = a.conditioned;
        const ConditionedPair& cb = b.conditioned;
        return ca.squared_distance < cb.squared_distance ||
               (ca.squared_distance == cb.squared_distance && ca.pair.prediction < cb.pair.prediction);
      });
      for (const Candidate* choice = begin; choice != group_end; ++choice) {
        if (!can_win(reachable, factor_.squared_distance() + choice->conditioned.squared_distance)) break;  // nor do farther ones
        if (gate_every_set_ && !passes_gate(factor_.size() + 1, factor_.squared_distance() + choice->conditioned.squared_distance)) {
          gated_on_the_way_ = true;
          break;
        }
        if (nodes_visited_ == node_budget_) {
          budget_exhausted_ = true;
          return;
        }
        ++nodes_visited_;
        factor_.push(choice->conditioned, row_of(*choice));
        keep_if_better();
        explore(end, open_below(*choice, group_end, end, reachable));
        factor_.pop();
        if (budget_exhausted_) return;
      }
      begin = group_end;  // next, the sets without this observation
    }
  }

  /// Copies the candidates that stay open once `choice` is accepted behind `end`, conditioned on it; returns their end.
  Candidate* open_below(const Candidate& choice, const Candidate* begin, Candidate* end, Eigen::Index reachable) {
    const Eigen::Index level = factor_.size() - 1;
    Candidate* kept = end;
    for (const Candidate* c = begin; c != end; ++c) {
      if (c->conditioned.pair.prediction == choice.conditioned.pair.prediction) continue;
      *kept = *c;
      factor_.condition(kept->conditioned, row_of(*kept), level);
      if (can_win(reachable, factor_.squared_distance() + kept->conditioned.squared_distance)) ++kept;
    }
    return kept;
  }

  std::vector<Eigen::Index> order_;
  Eigen::Index depth_;
  JointFactor factor_;
  std::vector<double> gates_;
  int node_budget_;
  Eigen::Matrix2Xd rows_;  ///< one block row of `depth_` blocks per candidate
  std::unique_ptr<Candidate[]> stack_;
  std::vector<Pair> best_pairs_;
  double best_squared_distance_ = 0.0;
  bool gate_every_set_ = false;
  bool gated_on_the_way_ = false;
  int nodes_visited_ = 0;
  bool budget_exhausted_ = false;
};

}  // namespace

Hypothesis joint_compatibility(const PairingProblem& problem, const Compatibility& compatibility,
                               const std::vector<Eigen::Index>& observations, const JointCompatibilityConfig& config) {
  if (config.node_budget < 1) throw InvalidArgument("node_budget", std::to_string(config.node_budget), "must be at least 1");
  Hypothesis hypothesis = Search(problem, compatibility, observations, config).result();
  hypothesis.nearest_squared_distance = nearest_squared_distances(compatibility);
  return hypothesis;
}

Hypothesis joint_compatibility(const PairingProblem& problem, const JointCompatibilityConfig& config) {
  const Compatibility compatibility = individual_compatibility(problem, joint_gates(config.gate_probability, 1).front());
  std::vector<Eigen::Index> observations(static_cast<std::size_t>(problem.observations()));
  std::iota(observations.begin(), observations.end(), Eigen::Index{0});
  return joint_compatibility(problem, compatibility, observations, config);
}

}  // namespace ssjs
