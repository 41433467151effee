#include "ssjs/evaluation/map_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_alignment.hpp"
#include "ssjs/geometry/point_grid.hpp"

namespace ssjs {
namespace {

using Pairing = std::vector<std::optional<Eigen::Index>>;  // per estimated landmark, the truth landmark

/// Least-cost assignment of rows to columns over a sparse list of allowed pairs: shortest augmenting paths with dual prices
/// [jonker1987]. Each row may also stay alone, at `alone_cost`, which is a private column of its own.
class SparseAssignment {
 public:
  SparseAssignment(std::size_t rows, std::size_t columns, double alone_cost) : shared_columns_(columns), edges_(rows) {
    for (std::size_t row = 0; row < rows; ++row) edges_[row].push_back({columns + row, alone_cost});
    const std::size_t all = columns + rows;
    row_price_.resize(rows);
    column_price_.assign(all, 0.0);
    row_of_.assign(all, kNone);
    column_of_.assign(rows, kNone);
    distance_.assign(all, kInfinity);
    reached_from_.assign(all, kNone);
    settled_.assign(all, false);
  }

  void allow(std::size_t row, std::size_t column, double cost) { edges_[row].push_back({column, cost}); }

  /// The column of each row; empty where the row stays alone.
  std::vector<std::optional<std::size_t>> solve() {
    // tight start: the cheapest pair of each row, where it is free; the other rows need a path
    std::vector<std::size_t> unassigned;
    for (std::size_t row = 0; row < edges_.size(); ++row) {
      const Edge cheapest =
          *std::min_element(edges_[row].begin(), edges_[row].end(), [](const Edge& a, const Edge& b) { return a.cost < b.cost; });
      row_price_[row] = cheapest.cost;
      if (row_of_[cheapest.column] == kNone) {
        assign(row, cheapest.column);
      } else {
        unassigned.push_back(row);
      }
    }
    for (const std::size_t row : unassigned) augment(row);
    std::vector<std::optional<std::size_t>> columns(edges_.size());
    for (std::size_t row = 0; row < edges_.size(); ++row) {
      if (column_of_[row] < shared_columns_) columns[row] = column_of_[row];
    }
    return columns;
  }

 private:
  struct Edge {
    std::size_t column;
    double cost;
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  void assign(std::size_t row, std::size_t column) {
    row_of_[column] = row;
    column_of_[row] = column;
  }

  /// Dijkstra over reduced costs from a free row to the nearest free column, then the prices and the path.
  void augment(std::size_t source) {
    using Candidate = std::pair<double, std::size_t>;  // distance, column: ties go to the lower column, so the result is reproducible
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> open;
    std::vector<std::size_t> touched;
    std::vector<std::size_t> settled;
    const auto scan = [&](std::size_t row, double reached) {
      for (const Edge& edge : edges_[row]) {
        const double through = reached + (edge.cost - row_price_[row] - column_price_[edge.column]);
        if (settled_[edge.column] || !(through < distance_[edge.column])) continue;
        if (distance_[edge.column] == kInfinity) touched.push_back(edge.column);
        distance_[edge.column] = through;
        reached_from_[edge.column] = row;
        open.emplace(through, edge.column);
      }
    };
    scan(source, 0.0);
    std::size_t sink = kNone;
    double length = 0.0;
    while (sink == kNone) {  // ends: the private column of the source is free
      const auto [reached, column] = open.top();
      open.pop();
      if (settled_[column]) continue;
      if (row_of_[column] == kNone) {
        sink = column;
        length = reached;
      } else {
        settled_[column] = true;
        settled.push_back(column);
        scan(row_of_[column], reached);
      }
    }
    row_price_[source] += length;
    for (const std::size_t column : settled) {
      row_price_[row_of_[column]] += length - distance_[column];
      column_price_[column] -= length - distance_[column];
    }
    for (std::size_t column = sink; column != kNone;) {
      const std::size_t row = reached_from_[column];
      const std::size_t released = column_of_[row];
      assign(row, column);
      column = released;
    }
    for (const std::size_t column : touched) distance_[column] = kInfinity;
    for (const std::size_t column : settled) settled_[column] = false;
  }

  std::size_t shared_columns_;
  std::vector<std::vector<Edge>> edges_;
  std::vector<double> row_price_, column_price_, distance_;
  std::vector<std::size_t> row_of_, column_of_, reached_from_;
  std::vector<bool> settled_;
};

struct Landmarks {
  Eigen::Matrix2Xd estimated;
  const std::vector<std::optional<std::int64_t>>& estimated_ids;
  Eigen::Matrix2Xd truth;
  const std::unordered_map<std::int64_t, Eigen::Index>& truth_of_id;
};

double pair_distance(const Landmarks& landmarks, Eigen::Index estimate, Eigen::Index truth) {
  return (landmarks.estimated.col(estimate) - landmarks.truth.col(truth)).norm();
}

/// By identity first, within max_distance_m, then the best assignment of what has none.
Pairing pair_landmarks(const Landmarks& landmarks, double max_distance_m, bool gate_identities) {
  const Eigen::Index estimates = landmarks.estimated.cols();
  const Eigen::Index truths = landmarks.truth.cols();
  Pairing pairing(static_cast<std::size_t>(estimates));
  std::vector<std::optional<Eigen::Index>> estimate_of(static_cast<std::size_t>(truths));
  std::vector<Eigen::Index> anonymous;
  for (Eigen::Index i = 0; i < estimates; ++i) {
    const std::optional<std::int64_t>& id = landmarks.estimated_ids[static_cast<std::size_t>(i)];
    const auto known = id ? landmarks.truth_of_id.find(*id) : landmarks.truth_of_id.end();
    if (known == landmarks.truth_of_id.end()) {
      anonymous.push_back(i);
      continue;
    }
    const double distance = pair_distance(landmarks, i, known->second);
    if (gate_identities && !(distance <= max_distance_m)) continue;
    std::optional<Eigen::Index>& holder = estimate_of[static_cast<std::size_t>(known->second)];
    if (!holder || distance < pair_distance(landmarks, *holder, known->second)) holder = i;
  }
  std::vector<Eigen::Index> free_truths;
  for (Eigen::Index j = 0; j < truths; ++j) {
    const std::optional<Eigen::Index>& holder = estimate_of[static_cast<std::size_t>(j)];
    if (holder) {
      pairing[static_cast<std::size_t>(*holder)] = j;
    } else {
      free_truths.push_back(j);
    }
  }
  if (anonymous.empty() || free_truths.empty()) return pairing;

  Eigen::Matrix2Xd free_points(2, static_cast<Eigen::Index>(free_truths.size()));
  for (std::size_t j = 0; j < free_truths.size(); ++j) free_points.col(static_cast<Eigen::Index>(j)) = landmarks.truth.col(free_truths[j]);
  const PointGrid grid(free_points, max_distance_m);
  SparseAssignment assignment(anonymous.size(), free_truths.size(), max_distance_m);  // (E-6)
  for (std::size_t i = 0; i < anonymous.size(); ++i) {
    for (const Eigen::Index j : grid.within(landmarks.estimated.col(anonymous[i]), max_distance_m)) {
      assignment.allow(i, static_cast<std::size_t>(j), pair_distance(landmarks, anonymous[i], free_truths[static_cast<std::size_t>(j)]));
    }
  }
  const std::vector<std::optional<std::size_t>> columns = assignment.solve();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i]) pairing[static_cast<std::size_t>(anonymous[i])] = free_truths[*columns[i]];
  }
  return pairing;
}

/// The motion of the estimate that fits the pairs best; empty with fewer than 2 distinct pairs.
std::optional<Se2> truth_T_estimate(const Eigen::Matrix2Xd& estimated, const Eigen::Matrix2Xd& truth, const Pairing& pairing) {
  Eigen::Matrix2Xd a(2, estimated.cols());
  Eigen::Matrix2Xd b(2, estimated.cols());
  Eigen::Index n = 0;
  for (std::size_t i = 0; i < pairing.size(); ++i) {
    if (const std::optional<Eigen::Index>& j = pairing[i]) {
      a.col(n) = truth.col(*j);
      b.col(n) = estimated.col(static_cast<Eigen::Index>(i));
      ++n;
    }
  }
  return align_points(a.leftCols(n), b.leftCols(n), Eigen::VectorXd());
}

void check(const Eigen::Ref<const Eigen::Matrix2Xd>& points, std::size_t ids, const std::string& name) {
  if (ids != static_cast<std::size_t>(points.cols())) {
    throw InvalidArgument("map_error " + name + "_ids", std::to_string(ids) + " entries",
                          "must have one per " + name + " landmark (" + std::to_string(points.cols()) + ")");
  }
  if (!points.allFinite()) throw InvalidArgument("map_error " + name, "NaN or infinity", "every coordinate must be finite");
}

}  // namespace

std::optional<MapError> map_error(const Eigen::Ref<const Eigen::Matrix2Xd>& estimated,
                                  const std::vector<std::optional<std::int64_t>>& estimated_ids,
                                  const Eigen::Ref<const Eigen::Matrix2Xd>& truth, const std::vector<std::int64_t>& truth_ids,
                                  const MapErrorConfig& config) {
  check(estimated, estimated_ids.size(), "estimated");
  check(truth, truth_ids.size(), "truth");
  if (!(config.max_distance_m > 0.0) || !std::isfinite(config.max_distance_m)) {
    throw InvalidArgument("MapErrorConfig.max_distance_m", config.max_distance_m, "must be positive and finite");
  }
  std::unordered_map<std::int64_t, Eigen::Index> truth_of_id;
  for (std::size_t j = 0; j < truth_ids.size(); ++j) {
    if (!truth_of_id.emplace(truth_ids[j], static_cast<Eigen::Index>(j)).second) {
      throw InvalidArgument("map_error truth_ids[" + std::to_string(j) + "]", std::to_string(truth_ids[j]), "identities must be unique");
    }
  }

  Landmarks landmarks{estimated, estimated_ids, truth, truth_of_id};
  Pairing pairing = pair_landmarks(landmarks, config.max_distance_m, !config.align);
  if (config.align) {
    // the pairs depend on the motion and the motion on the pairs: repeated until they agree
    constexpr int kMaxRounds = 50;
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::optional<Se2> motion = truth_T_estimate(estimated, truth, pairing);
      if (!motion) return std::nullopt;
      for (Eigen::Index i = 0; i < estimated.cols(); ++i) landmarks.estimated.col(i) = *motion * Eigen::Vector2d(estimated.col(i));
      Pairing repeated = pair_landmarks(landmarks, config.max_distance_m, true);
      if (repeated == pairing) break;
      pairing = std::move(repeated);
    }
  }

  MapError result;
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairing.size(); ++i) {
    if (pairing[i]) errors.push_back(pair_distance(landmarks, static_cast<Eigen::Index>(i), *pairing[i]));
  }
  if (errors.empty()) return std::nullopt;
  double sum = 0.0;
  double square_sum = 0.0;
  for (const double error : errors) {
    sum += error;
    square_sum += error * error;
    result.max_m = std::max(result.max_m, error);
  }
  const double n = static_cast<double>(errors.size());
  result.mean_m = sum / n;  // (E-7)
  result.rmse_m = std::sqrt(square_sum / n);
  double deviation_sum = 0.0;
  for (const double error : errors) deviation_sum += (error - result.mean_m) * (error - result.mean_m);
  result.std_m = std::sqrt(deviation_sum / n);
  result.matched = static_cast<int>(errors.size());
  result.missed = static_cast<int>(truth.cols()) - result.matched;
  result.false_landmarks = static_cast<int>(estimated.cols()) - result.matched;
  result.truth_of = std::move(pairing);
  return result;
}

}  // namespace ssjs
