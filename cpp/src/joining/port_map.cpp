#include "ssjs/joining/port_map.hpp"

#include <algorithm>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

bool is_angle(const LevelledSubmap& submap, Eigen::Index row) {
  return row == 2 || (row >= LevelledSubmap::compass_offset() && row < LevelledSubmap::compass_offset() + submap.compass_rows());
}

Eigen::Index total_rows(const std::vector<Port>& ports) {
  Eigen::Index rows = 0;
  for (const Port& port : ports) rows += rows_of(port.unknown.kind);
  return rows;
}

}  // namespace

void PortValues::move(const Unknown& unknown, const Eigen::Ref<const Eigen::VectorXd>& step) {
  const auto at = static_cast<std::size_t>(unknown.index);
  switch (unknown.kind) {
    case UnknownKind::kBase:
      bases[at] = additive_step(bases[at], step);
      break;
    case UnknownKind::kOffset:
      offsets[at] = wrap_angle(offsets[at] + step(0));
      break;
    case UnknownKind::kLandmark:
      landmarks[at] += step;
      break;
  }
}

bool PortValues::holds(const Unknown& unknown) const {
  const std::size_t size = unknown.kind == UnknownKind::kBase     ? bases.size()
                           : unknown.kind == UnknownKind::kOffset ? offsets.size()
                                                                  : landmarks.size();
  return unknown.index >= 0 && static_cast<std::size_t>(unknown.index) < size;
}

std::optional<Unknown> PortMap::unknown_at(Eigen::Index row) const {
  const auto found = std::find_if(ports.begin(), ports.end(), [row](const Port& port) { return port.row == row; });
  if (found == ports.end()) return std::nullopt;
  return found->unknown;
}

Eigen::VectorXi state_rows(const std::vector<Port>& ports) {
  Eigen::VectorXi rows(total_rows(ports));
  Eigen::Index at = 0;
  for (const Port& port : ports) {
    for (Eigen::Index i = 0; i < rows_of(port.unknown.kind); ++i) rows(at++) = static_cast<int>(port.row + i);
  }
  return rows;
}

PortPlacement place_ports(int base, const std::vector<Port>& ports, const PortValues& values) {
  const Eigen::Index n = total_rows(ports);
  PortPlacement placed{Eigen::VectorXd(n), Eigen::MatrixXd::Zero(n, 3 + n), {{UnknownKind::kBase, base}}, {0}};
  const Se2& global_T_base = values.base(base);
  Eigen::Index row = 0;
  for (const Port& port : ports) {
    const Eigen::Index column = 3 + row;
    placed.unknowns.push_back(port.unknown);
    placed.columns.push_back(column);
    switch (port.unknown.kind) {
      case UnknownKind::kBase: {  // t = (-)X_k (+) X_u
        const RelativePose relative = relative_pose(global_T_base, values.base(port.unknown.index));
        placed.s.segment<3>(row) = relative.i_T_j.vector();
        placed.J.block<3, 3>(row, 0) = relative.J_i;
        placed.J.block<3, 3>(row, column) = relative.J_j;
        break;
      }
      case UnknownKind::kOffset:  // compass minus heading in the map = psi_k + c_u
        placed.s(row) = wrap_angle(global_T_base.heading + values.offset(port.unknown.index));
        placed.J(row, 2) = 1.0;
        placed.J(row, column) = 1.0;
        break;
      case UnknownKind::kLandmark: {  // (-)X_k (+) l_u in the plane, the depth as it is
        const Eigen::Vector3d& global_p = values.landmark(port.unknown.index);
        const Eigen::Matrix2d base_R_global = global_T_base.rotation().transpose();
        const Eigen::Vector2d base_p = base_R_global * (global_p.head<2>() - global_T_base.translation());
        placed.s.segment<3>(row) << base_p, global_p.z();
        placed.J.block<2, 2>(row, 0) = -base_R_global;
        placed.J.block<2, 1>(row, 2) << base_p.y(), -base_p.x();
        placed.J.block<2, 2>(row, column) = base_R_global;
        placed.J(row + 2, column + 2) = 1.0;
        break;
      }
    }
    row += rows_of(port.unknown.kind);
  }
  return placed;
}

Eigen::VectorXd port_difference(const std::vector<Port>& ports, const Eigen::Ref<const Eigen::VectorXd>& left,
                                const Eigen::Ref<const Eigen::VectorXd>& right) {
  Eigen::VectorXd difference = left - right;
  Eigen::Index row = 0;
  for (const Port& port : ports) {
    if (port.unknown.kind == UnknownKind::kBase) difference(row + 2) = wrap_angle(difference(row + 2));
    if (port.unknown.kind == UnknownKind::kOffset) difference(row) = wrap_angle(difference(row));
    row += rows_of(port.unknown.kind);
  }
  return difference;
}

ConditionalRows condition_on_ports(const PortMap& map, const Eigen::VectorXi& rows) {
  const Eigen::MatrixXd& P = map.submap.covariance;
  if (map.ports.empty()) return {Eigen::MatrixXd(rows.size(), 0), P(rows, rows)};
  const Eigen::VectorXi s = state_rows(map.ports);
  if (rows.size() == 0) return {Eigen::MatrixXd(0, s.size()), Eigen::MatrixXd(0, 0)};
  const std::string name = "map " + std::to_string(map.base());
  const Eigen::MatrixXd L = cholesky_lower(P(s, s), "covariance of the ports", name.c_str());
  Eigen::MatrixXd Y = P(s, rows);
  L.triangularView<Eigen::Lower>().solveInPlace(Y);  // L^-1 P_sm
  ConditionalRows conditional{{}, P(rows, rows) - Y.transpose() * Y};
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(Y);
  conditional.K = Y.transpose();  // (P-5): K = P_ms P_ss^-1
  conditional.C = 0.5 * (conditional.C + conditional.C.transpose()).eval();
  return conditional;
}

ConditionalPlacement place_rows(const PortMap& map, const Eigen::VectorXi& rows, const PortValues& values) {
  const ConditionalRows conditional = condition_on_ports(map, rows);
  const PortPlacement placed = place_ports(map.base(), map.ports, values);
  const Eigen::VectorXi s = state_rows(map.ports);
  ConditionalPlacement result{map.submap.mean(rows), conditional.K * placed.J, conditional.C, placed.unknowns, placed.columns};
  result.mean += conditional.K * port_difference(map.ports, placed.s, map.submap.mean(s));  // (P-5)
  for (Eigen::Index i = 0; i < rows.size(); ++i) {
    if (is_angle(map.submap, rows(i))) result.mean(i) = wrap_angle(result.mean(i));
  }
  return result;
}

WorldPoint to_world(const Se2& global_T_base, const Eigen::Vector3d& base_p) {
  WorldPoint point{base_p, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Identity()};
  point.position.head<2>() = global_T_base * Eigen::Vector2d(base_p.head<2>());
  point.J_base.topRows<2>() = act_jacobian(global_T_base, base_p.head<2>());
  point.J_point.topLeftCorner<2, 2>() = global_T_base.rotation();
  return point;
}

}  // namespace ssjs
