#include "ssjs/joining/consistent_set.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Graph = std::vector<std::vector<std::size_t>>;  // neighbours, ascending

/// Branch and bound over one connected piece of the graph of contradictions.
class Search {
 public:
  Search(const Graph& piece, const std::vector<double>& weights, int node_budget)
      : graph_(piece), weights_(weights), budget_(node_budget), state_(piece.size(), State::kOpen) {
    choose_greedily();
    branch(0.0);
  }

  [[nodiscard]] const std::vector<bool>& best() const { return best_; }
  [[nodiscard]] bool exact() const { return budget_ >= 0; }

 private:
  enum class State : std::uint8_t { kOpen, kIn, kOut };

  [[nodiscard]] bool is_open(std::size_t v) const { return state_[v] == State::kOpen; }

  /// The heaviest for what it contradicts first: the fall-back, and what the search has to beat.
  void choose_greedily() {
    best_.assign(graph_.size(), false);
    std::vector<bool> open(graph_.size(), true);
    while (true) {
      std::optional<std::size_t> next;
      double next_merit = 0.0;
      for (std::size_t v = 0; v < graph_.size(); ++v) {
        if (!open[v]) continue;
        double merit = weights_[v];
        for (const std::size_t n : graph_[v]) merit -= open[n] ? weights_[n] : 0.0;
        if (!next || merit > next_merit) {
          next = v;
          next_merit = merit;
        }
      }
      if (!next) return;
      best_[*next] = true;
      best_weight_ += weights_[*next];
      open[*next] = false;
      for (const std::size_t n : graph_[*next]) open[n] = false;
    }
  }

  /// Weight that the open closures can add at most: of two that contradict each other one goes, and no weight is charged twice. (C-8)
  [[nodiscard]] double bound() const {
    std::vector<double> left(graph_.size(), 0.0);
    double most = 0.0;
    for (std::size_t v = 0; v < graph_.size(); ++v) {
      if (is_open(v)) most += left[v] = weights_[v];
    }
    for (std::size_t v = 0; v < graph_.size(); ++v) {
      for (const std::size_t n : graph_[v]) {
        if (n < v) continue;
        const double paid = std::min(left[v], left[n]);
        left[v] -= paid;
        left[n] -= paid;
        most -= paid;
      }
    }
    return most;
  }

  void branch(double weight) {
    if (--budget_ < 0) return;
    std::vector<std::size_t> settled;
    std::optional<std::size_t> split;  // the one that contradicts most
    std::size_t most = 0;
    for (std::size_t v = 0; v < graph_.size(); ++v) {
      if (!is_open(v)) continue;
      const auto degree =
          static_cast<std::size_t>(std::count_if(graph_[v].begin(), graph_[v].end(), [&](std::size_t n) { return is_open(n); }));
      if (degree == 0) {  // nothing speaks against it
        weight += weights_[v];
        state_[v] = State::kIn;
        settled.push_back(v);
      } else if (degree > most) {
        most = degree;
        split = v;
      }
    }
    if (!split) {
      take_over(weight);
    } else if (weight + bound() > best_weight_) {
      branch_on(*split, weight);
    }
    for (const std::size_t v : settled) state_[v] = State::kOpen;
  }

  void branch_on(std::size_t v, double weight) {
    std::vector<std::size_t> refused;
    for (const std::size_t n : graph_[v]) {
      if (is_open(n)) refused.push_back(n);
    }
    state_[v] = State::kOut;
    branch(weight);
    state_[v] = State::kIn;
    for (const std::size_t n : refused) state_[n] = State::kOut;
    branch(weight + weights_[v]);
    for (const std::size_t n : refused) state_[n] = State::kOpen;
    state_[v] = State::kOpen;
  }

  void take_over(double weight) {
    if (!(weight > best_weight_)) return;
    best_weight_ = weight;
    for (std::size_t v = 0; v < graph_.size(); ++v) best_[v] = state_[v] == State::kIn;
  }

  const Graph& graph_;
  const std::vector<double>& weights_;
  int budget_;
  std::vector<State> state_;
  std::vector<bool> best_;
  double best_weight_ = 0.0;
};

/// The closures that hang together with `start` by contradictions, ascending.
std::vector<std::size_t> piece_around(std::size_t start, const Graph& graph, std::vector<bool>& visited) {
  std::vector<std::size_t> piece{start};
  visited[start] = true;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    for (const std::size_t n : graph[piece[i]]) {
      if (visited[n]) continue;
      visited[n] = true;
      piece.push_back(n);
    }
  }
  std::sort(piece.begin(), piece.end());
  return piece;
}

/// The piece with its closures numbered from 0 on.
Graph renumbered(const Graph& graph, const std::vector<std::size_t>& piece) {
  Graph local(piece.size());
  for (std::size_t i = 0; i < piece.size(); ++i) {
    for (const std::size_t n : graph[piece[i]]) {
      local[i].push_back(static_cast<std::size_t>(std::lower_bound(piece.begin(), piece.end(), n) - piece.begin()));
    }
  }
  return local;
}

}  // namespace

ConsistentSet heaviest_consistent_set(const std::vector<double>& weights,
                                      const std::vector<std::pair<std::size_t, std::size_t>>& contradictions, int node_budget) {
  for (const double weight : weights) {
    if (!(weight > 0.0)) throw InvalidArgument("weights", weight, "must be positive");
  }
  Graph graph(weights.size());
  for (const auto& [a, b] : contradictions) {
    if (a >= weights.size() || b >= weights.size() || a == b) {
      throw InvalidArgument("contradictions", std::to_string(a) + " and " + std::to_string(b), "two different closures of the list");
    }
    graph[a].push_back(b);
    graph[b].push_back(a);
  }
  for (std::vector<std::size_t>& neighbours : graph) {
    std::sort(neighbours.begin(), neighbours.end());
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  }
  ConsistentSet result;
  result.kept.assign(weights.size(), false);
  std::vector<bool> visited(weights.size(), false);
  for (std::size_t v = 0; v < weights.size(); ++v) {
    if (visited[v]) continue;
    if (graph[v].empty()) {
      result.kept[v] = true;
    } else {
      const std::vector<std::size_t> piece = piece_around(v, graph, visited);
      const Graph local = renumbered(graph, piece);
      std::vector<double> local_weights;
      for (const std::size_t member : piece) local_weights.push_back(weights[member]);
      const Search search(local, local_weights, node_budget);
      for (std::size_t i = 0; i < piece.size(); ++i) result.kept[piece[i]] = search.best()[i];
      result.exact = result.exact && search.exact();
    }
  }
  for (std::size_t v = 0; v < weights.size(); ++v) result.weight += result.kept[v] ? weights[v] : 0.0;
  return result;
}

}  // namespace ssjs
