#include "ssjs/joining/duplicate_landmarks.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/geometry/point_grid.hpp"
#include "ssjs/joining/nearby_maps.hpp"

namespace ssjs {
namespace {

constexpr double kConstraintVariance = 1e-12;  // m^2: exact constraints, kept invertible

double largest_sigma(const Eigen::Matrix2d& covariance) {
  return std::sqrt(std::max(0.0, covariance.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff()));
}

/// Covariance of the displacement between two landmarks of the map.
Eigen::Matrix2d displacement_covariance(const LiveMap& map, Eigen::Index i, Eigen::Index j) {
  const auto rows_i = map.landmark(i);
  const auto rows_j = map.landmark(j);
  const Eigen::Matrix2d cross = map.covariance(rows_i, rows_j);
  return map.covariance(rows_i, rows_i) + map.covariance(rows_j, rows_j) - cross - cross.transpose();
}

Eigen::VectorXi rows_of(const LiveMap& map, const std::vector<Eigen::Index>& landmarks) {
  Eigen::VectorXi rows(static_cast<Eigen::Index>(2 * landmarks.size()));
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto at = static_cast<int>(map.landmark_offset(landmarks[i]));
    rows(static_cast<Eigen::Index>(2 * i)) = at;
    rows(static_cast<Eigen::Index>(2 * i) + 1) = at + 1;
  }
  return rows;
}

/// Recent and other landmarks that may be copies of each other by their own distances.
struct Suspects {
  std::vector<Eigen::Index> recent, others;
};

Suspects suspects_of(const LiveMap& map, const std::vector<Eigen::Index>& recent,
                     const std::function<bool(Eigen::Index, Eigen::Index)>& distinct, double largest_sigma_m) {
  const double reach_m = kReachSigmas * largest_sigma_m;
  std::vector<Eigen::Index> others;
  for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
    if (!std::binary_search(recent.begin(), recent.end(), i)) others.push_back(i);
  }
  if (others.empty()) return {};
  Eigen::Matrix2Xd points(2, static_cast<Eigen::Index>(others.size()));
  for (std::size_t i = 0; i < others.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = map.mean(map.landmark(others[i]));
  const PointGrid grid(points, reach_m);
  Suspects suspects;
  std::vector<bool> suspected(others.size(), false);
  for (const Eigen::Index i : recent) {
    bool any = false;
    for (const Eigen::Index at : grid.within(map.mean(map.landmark(i)), reach_m)) {
      const Eigen::Index j = others[static_cast<std::size_t>(at)];
      if (distinct(i, j) || !(largest_sigma(displacement_covariance(map, i, j)) <= largest_sigma_m)) continue;
      suspected[static_cast<std::size_t>(at)] = any = true;
    }
    if (any) suspects.recent.push_back(i);
  }
  for (std::size_t at = 0; at < others.size(); ++at) {
    if (suspected[at]) suspects.others.push_back(others[at]);
  }
  return suspects;
}

}  // namespace

Duplicates find_duplicates(const LiveMap& map, const std::vector<Eigen::Index>& recent,
                           const std::function<bool(Eigen::Index, Eigen::Index)>& distinct, MapAssociator& associator) {
  const auto gate_m = associator.ambiguity_gate();
  if (!gate_m) return {};  // identities are known, or nothing tells what is too unsure
  const Suspects suspects = suspects_of(map, recent, distinct, *gate_m);
  if (suspects.recent.empty()) return {};
  const Eigen::VectorXi rows_recent = rows_of(map, suspects.recent);
  const Eigen::VectorXi rows_others = rows_of(map, suspects.others);
  PairingProblem problem;
  problem.observed = map.mean(rows_recent);
  problem.predicted = map.mean(rows_others);
  problem.observed_covariance = map.covariance(rows_recent, rows_recent);
  problem.predicted_covariance = map.covariance(rows_others, rows_others);
  problem.cross_covariance = map.covariance(rows_others, rows_recent);
  const Hypothesis hypothesis = associator.associate(problem);
  Duplicates found;
  found.budget_exhausted = hypothesis.budget_exhausted;
  for (const Pair& pair : hypothesis.pairs) {
    const Eigen::Index i = suspects.recent[static_cast<std::size_t>(pair.observation)];
    const Eigen::Index j = suspects.others[static_cast<std::size_t>(pair.prediction)];
    if (distinct(i, j) || !(largest_sigma(displacement_covariance(map, i, j)) <= *gate_m)) continue;
    found.pairs.push_back({i, j});
  }
  return found;
}

double merge_duplicates(LiveMap& map, const std::vector<Pair>& pairs) {
  if (pairs.empty()) return 0.0;
  const auto rows = static_cast<Eigen::Index>(2 * pairs.size());
  Eigen::MatrixXd Y(map.mean.size(), rows);  // P C', then P C' L^-T
  Eigen::VectorXd Cx(rows);
  for (Eigen::Index row = 0; row < rows; row += 2) {
    const Pair& pair = pairs[static_cast<std::size_t>(row / 2)];
    const Eigen::Index i = map.landmark_offset(pair.observation);
    const Eigen::Index j = map.landmark_offset(pair.prediction);
    Y.middleCols<2>(row) = map.covariance.middleCols<2>(i) - map.covariance.middleCols<2>(j);
    Cx.segment<2>(row) = map.mean.segment<2>(i) - map.mean.segment<2>(j);
  }
  Eigen::MatrixXd S(rows, rows);
  for (Eigen::Index row = 0; row < rows; row += 2) {
    const Pair& pair = pairs[static_cast<std::size_t>(row / 2)];
    S.middleRows<2>(row) = Y.middleRows<2>(map.landmark_offset(pair.observation)) - Y.middleRows<2>(map.landmark_offset(pair.prediction));
  }
  S.diagonal().array() += kConstraintVariance;
  const std::string name = "duplicates in the map at base " + std::to_string(map.base);
  const Eigen::MatrixXd L = cholesky_lower(S, "constraint covariance", name.c_str());
  L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(Y);
  const Eigen::VectorXd whitened = L.triangularView<Eigen::Lower>().solve(Cx);
  map.mean.noalias() -= Y * whitened;  // (L-5)
  for (Eigen::Index i = 0; i < map.pose_count(); ++i) map.mean(3 * i + 2) = wrap_angle(map.mean(3 * i + 2));
  map.covariance.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
  mirror_lower(map.covariance);

  std::vector<bool> dropped(map.landmarks.size(), false);
  for (const Pair& pair : pairs) {
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(std::min(pair.observation, pair.prediction))];
    const auto later = static_cast<std::size_t>(std::max(pair.observation, pair.prediction));
    kept.take(map.landmarks[later]);
    if (!kept.source_id) kept.source_id = map.landmarks[later].source_id;
    dropped[later] = true;
  }
  std::vector<int> rows_kept;
  std::vector<MapLandmark> landmarks;
  for (int row = 0; row < static_cast<int>(3 * map.pose_count()); ++row) rows_kept.push_back(row);
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    if (dropped[i]) continue;
    const auto at = static_cast<int>(map.landmark_offset(static_cast<Eigen::Index>(i)));
    rows_kept.push_back(at);
    rows_kept.push_back(at + 1);
    landmarks.push_back(std::move(map.landmarks[i]));
  }
  map.landmarks = std::move(landmarks);
  map.mean = map.mean(rows_kept).eval();
  map.covariance = map.covariance(rows_kept, rows_kept).eval();
  return whitened.squaredNorm();
}

}  // namespace ssjs
