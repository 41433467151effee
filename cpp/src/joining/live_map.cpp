#include "ssjs/joining/live_map.hpp"

#include <algorithm>
#include <numeric>
#include <string>

namespace ssjs {
namespace {

constexpr double kExitVariance = 1e-12;  // (1 um)^2 and (1 urad)^2: keeps the port covariance of a vehicle that hardly moved invertible

/// Poses as listed; the landmarks stay where they are.
void reorder_poses(LiveMap& map, const std::vector<Eigen::Index>& order) {
  const Eigen::Index n = map.mean.size();
  const Eigen::Index p = 3 * map.pose_count();
  Eigen::MatrixXd& P = map.covariance;
  const std::vector<int> ids = map.poses;
  const Eigen::VectorXd mean = map.mean.head(p);
  const Eigen::MatrixXd columns = P.leftCols(p);
  const Eigen::MatrixXd rows = P.topRightCorner(p, n - p);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto to = static_cast<Eigen::Index>(3 * i);
    map.poses[i] = ids[static_cast<std::size_t>(order[i])];
    map.mean.segment<3>(to) = mean.segment<3>(3 * order[i]);
    for (std::size_t j = 0; j < order.size(); ++j) {
      P.block<3, 3>(static_cast<Eigen::Index>(3 * j), to) = columns.block<3, 3>(3 * order[j], 3 * order[i]);
    }
    P.block(p, to, n - p, 3) = columns.block(p, 3 * order[i], n - p, 3);
    P.block(to, p, 3, n - p) = rows.middleRows(3 * order[i], 3);
  }
}

void set_conditional_form(LiveMap& map) {
  const Eigen::Index s = map.port_size();
  const Eigen::Index m = map.mean.size() - s;
  if (s == 0) {
    map.K.resize(m, 0);
    map.port_information.resize(0, 0);
    return;
  }
  const std::string name = "map at base " + std::to_string(map.base);
  const Eigen::MatrixXd L = cholesky_lower(map.covariance.topLeftCorner(s, s), "port covariance", name.c_str());
  const Eigen::MatrixXd Li = L.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(s, s));
  map.port_information.noalias() = Li.transpose() * Li;
  map.K = map.covariance.bottomLeftCorner(m, s);  // (J-2): K = P_ms P_ss^-1
  L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(map.K);
  L.triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(map.K);
}

void set_extent(LiveMap& map) {
  map.centroid.setZero();
  map.radius = 0.0;
  const Eigen::Index n = map.landmark_count();
  if (n == 0) return;
  const Eigen::Map<const Eigen::Matrix2Xd> points(map.mean.data() + map.landmark_offset(0), 2, n);
  map.centroid = points.rowwise().mean();
  map.radius = (points.colwise() - map.centroid).colwise().norm().maxCoeff();
}

}  // namespace

std::optional<Eigen::Index> LiveMap::pose_of(int base_index) const {
  const auto found = std::find(poses.begin(), poses.end(), base_index);
  if (found == poses.end()) return std::nullopt;
  return found - poses.begin();
}

Eigen::MatrixXd LiveMap::conditional_covariance() const {
  const Eigen::Index m = mean.size() - port_size();
  return conditional_covariance(Eigen::VectorXi::LinSpaced(m, 0, static_cast<int>(m) - 1));
}

Eigen::MatrixXd LiveMap::conditional_covariance(const Eigen::VectorXi& of_m) const {
  const Eigen::VectorXi rows = of_m.array() + static_cast<int>(port_size());
  Eigen::MatrixXd C = covariance(rows, rows);
  C.noalias() -= K(of_m, Eigen::all) * covariance(Eigen::seqN(0, port_size()), rows);  // (J-2)
  return 0.5 * (C + C.transpose());
}

LiveMap live_map_of(const Submap& submap) {
  LiveMap map;
  map.base = submap.index;
  map.members = {submap.index};
  map.poses = {submap.index + 1};
  map.landmarks = submap.landmarks;
  map.mean = submap.state.mean;  // (J-1): the vehicle block is the exit pose, the layouts coincide
  map.covariance = submap.state.covariance;
  map.covariance.topLeftCorner<3, 3>().diagonal().array() += kExitVariance;
  set_ports(map, {true});
  return map;
}

void remove_poses(LiveMap& map, const std::vector<Eigen::Index>& removed) {
  if (removed.empty()) return;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < map.pose_count(); ++i) {
    if (std::find(removed.begin(), removed.end(), i) == removed.end()) kept.push_back(i);
  }
  const Eigen::Index landmark_rows = 2 * map.landmark_count();
  Eigen::VectorXi rows(static_cast<Eigen::Index>(3 * kept.size()) + landmark_rows);
  Eigen::Index row = 0;
  for (const Eigen::Index pose : kept) {
    for (Eigen::Index c = 0; c < 3; ++c) rows(row++) = static_cast<int>(3 * pose + c);
  }
  for (Eigen::Index i = 0; i < landmark_rows; ++i) rows(row++) = static_cast<int>(map.landmark_offset(0) + i);
  map.mean = Eigen::VectorXd(map.mean(rows));
  map.covariance = Eigen::MatrixXd(map.covariance(rows, rows));
  std::vector<int> poses;
  for (const Eigen::Index pose : kept) poses.push_back(map.poses[static_cast<std::size_t>(pose)]);
  map.poses = std::move(poses);
  map.ports = 0;
}

void set_ports(LiveMap& map, const std::vector<bool>& is_port) {
  std::vector<Eigen::Index> order(map.poses.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  const auto internal =
      std::stable_partition(order.begin(), order.end(), [&](Eigen::Index i) { return is_port[static_cast<std::size_t>(i)]; });
  map.ports = internal - order.begin();
  if (!std::is_sorted(order.begin(), order.end())) reorder_poses(map, order);
  set_conditional_form(map);
  set_extent(map);
}

}  // namespace ssjs
