#include "ssjs/joining/recursive_ports.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

RecursivePorts::RecursivePorts(double relinearize_heading_rad) : relinearize_heading_rad_(relinearize_heading_rad) {
  if (!(relinearize_heading_rad > 0.0)) throw InvalidArgument("relinearize_heading_rad", relinearize_heading_rad, "must be positive");
  values_.bases.emplace_back();
  turned_rad_.push_back(0.0);
  blocks_.push_back({{UnknownKind::kBase, 0}, 0});
  row_of_[blocks_.front().unknown] = 0;
  P_.setZero(3, 3);  // base 0 is the world
}

Eigen::MatrixXd RecursivePorts::over_state(const Eigen::MatrixXd& J, const std::vector<Unknown>& unknowns,
                                           const std::vector<Eigen::Index>& columns) const {
  Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(J.rows(), P_.rows());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Eigen::Index count = rows_of(unknowns[i].kind);
    whole.middleCols(row_of_.at(unknowns[i]), count) += J.middleCols(columns[i], count);
  }
  return whole;
}

void RecursivePorts::augment(const std::vector<Unknown>& unknowns, const Eigen::MatrixXd& J, const Eigen::MatrixXd& noise) {
  const Eigen::Index n = P_.rows();
  const Eigen::MatrixXd JP = J * P_;
  P_.conservativeResize(n + J.rows(), n + J.rows());
  P_.bottomLeftCorner(J.rows(), n) = JP;
  P_.topRightCorner(n, J.rows()) = JP.transpose();
  P_.bottomRightCorner(J.rows(), J.rows()) = JP * J.transpose() + noise;
  Eigen::Index row = n;
  for (const Unknown& unknown : unknowns) {
    blocks_.push_back({unknown, row});
    row_of_[unknown] = row;
    row += rows_of(unknown.kind);
    if (unknown.kind == UnknownKind::kBase) turned_rad_.push_back(0.0);
  }
}

void RecursivePorts::align_to_north(const PortMap& map, Eigen::Index row, const OffsetPrior& prior) {
  factors_.align_to_north(map, row, prior);
  values_.offsets.push_back(prior.mean_rad);
  augment({{UnknownKind::kOffset, 0}}, Eigen::MatrixXd::Zero(1, 3), Eigen::MatrixXd::Constant(1, 1, prior.variance));
  values_.bases.front().heading = wrap_angle(map.submap.mean(row) - prior.mean_rad);  // psi_0 = c_s - c_0
  P_(2, 2) = prior.variance + map.submap.covariance(row, row);
  P_(2, 3) = P_(3, 2) = -prior.variance;
}

void RecursivePorts::introduce(const PortMap& map, const std::vector<Port>& ports) {
  const ConditionalPlacement m = place_rows(map, state_rows(ports), values_);
  factors_.introduce(map, ports);
  Eigen::MatrixXd J = m.J;  // of m over the unknowns of the ports in use, then of the new unknowns
  const Eigen::Index rows = J.rows();
  Eigen::MatrixXd G = Eigen::MatrixXd::Identity(rows, rows);  // d(new unknowns)/dm
  const Se2 global_T_base = values_.base(map.base());
  Eigen::MatrixXd J_base = Eigen::MatrixXd::Zero(rows, 3);
  std::vector<Unknown> unknowns;
  Eigen::Index row = 0;
  for (const Port& port : ports) {  // (P-7)
    unknowns.push_back(port.unknown);
    switch (port.unknown.kind) {
      case UnknownKind::kBase:
        J_base.middleRows<3>(row) = compose_jacobian_left(global_T_base, Se2::from_vector(m.mean.segment<3>(row)));
        G.block<3, 3>(row, row) = compose_jacobian_right(global_T_base);
        break;
      case UnknownKind::kOffset:
        J_base(row, 2) = -1.0;
        break;
      case UnknownKind::kLandmark: {
        const WorldPoint point = to_world(global_T_base, m.mean.segment<3>(row));
        J_base.middleRows<3>(row) = point.J_base;
        G.block<3, 3>(row, row) = point.J_point;
        break;
      }
    }
    row += rows_of(port.unknown.kind);
  }
  append_values(values_, map, ports);
  J = G * J;
  J.leftCols<3>() += J_base;
  augment(unknowns, over_state(J, m.unknowns, m.columns), G * m.noise * G.transpose());
}

void RecursivePorts::tie(const PortMap& map, const std::vector<Port>& ports) {
  factors_.tie(map, ports);
  const PortPlacement seen = place_ports(map.base(), ports, values_);
  const ConditionalPlacement m = place_rows(map, state_rows(ports), values_);
  const Eigen::MatrixXd H = over_state(seen.J, seen.unknowns, seen.columns) - over_state(m.J, m.unknowns, m.columns);
  update(port_difference(ports, seen.s, m.mean), H, m.noise, "ports of map " + std::to_string(map.base()));  // (P-8)
}

void RecursivePorts::update(const Eigen::VectorXd& residual, const Eigen::MatrixXd& H, const Eigen::MatrixXd& noise,
                            const std::string& name) {
  const Eigen::MatrixXd PHt = P_ * H.transpose();
  const Eigen::MatrixXd L = cholesky_lower(H * PHt + noise, "innovation covariance", name.c_str());
  const Eigen::MatrixXd Y = L.triangularView<Eigen::Lower>().solve(PHt.transpose());  // L^-1 H P
  const Eigen::VectorXd step = -Y.transpose() * L.triangularView<Eigen::Lower>().solve(residual);
  P_.noalias() -= Y.transpose() * Y;
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  for (const Block& block : blocks_) {
    const Eigen::VectorXd move = step.segment(block.row, rows_of(block.unknown.kind));
    values_.move(block.unknown, move);
    if (block.unknown.kind == UnknownKind::kBase) turned_rad_[static_cast<std::size_t>(block.unknown.index)] += std::abs(move(2));
  }
}

void RecursivePorts::drift(int from, double variance) {
  factors_.drift(from, variance);
  values_.offsets.push_back(values_.offset(from));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(1, P_.rows());
  J(0, row_of_.at({UnknownKind::kOffset, from})) = 1.0;
  augment({{UnknownKind::kOffset, static_cast<int>(values_.offsets.size()) - 1}}, J, Eigen::MatrixXd::Constant(1, 1, variance));
}

void RecursivePorts::merge_landmarks(int keep, int gone) {
  factors_.merge_landmarks(keep, gone);
  const Unknown stays{UnknownKind::kLandmark, keep};
  const Unknown leaves{UnknownKind::kLandmark, gone};
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3, P_.rows());
  H.middleCols<3>(row_of_.at(stays)).setIdentity();
  H.middleCols<3>(row_of_.at(leaves)) = -Eigen::Matrix3d::Identity();
  const Eigen::Vector3d difference = values_.landmark(keep) - values_.landmark(gone);
  update(difference, H, Eigen::Matrix3d::Zero(), "landmarks " + std::to_string(keep) + " and " + std::to_string(gone));  // (P-19)

  std::vector<Eigen::Index> rest;
  std::vector<Block> blocks;
  for (const Block& block : blocks_) {
    if (block.unknown == leaves) continue;
    blocks.push_back({block.unknown, static_cast<Eigen::Index>(rest.size())});
    row_of_[block.unknown] = blocks.back().row;
    for (Eigen::Index i = 0; i < rows_of(block.unknown.kind); ++i) rest.push_back(block.row + i);
  }
  row_of_.erase(leaves);
  blocks_ = std::move(blocks);
  P_ = P_(rest, rest).eval();
}

/// The state knows nothing of a position that is free: with the first fix it starts anew from the factors.
void RecursivePorts::free_start(const StartPrior& prior) { factors_.free_start(prior); }

void RecursivePorts::fix(const FixFactor& fix) {
  factors_.fix(fix);
  if (!is_free_) {
    is_free_ = true;
    adjust();
    return;
  }
  const PlacedFix placed = place_fix(values_.base(fix.base), fix.base_p);
  const Eigen::MatrixXd H = over_state(placed.J_base, {{UnknownKind::kBase, fix.base}}, {0});
  update(placed.world_p - fix.world_p, H, fix.covariance, "fix of base " + std::to_string(fix.base));  // (P-30)
}

void RecursivePorts::loosen(const PortMap& map) {
  factors_.loosen(map);
  adjust();  // (P-9)
}

void RecursivePorts::settle() {
  if (*std::max_element(turned_rad_.begin(), turned_rad_.end()) > relinearize_heading_rad_) adjust();
}

void RecursivePorts::adjust() {
  factors_.set_values(values_);  // (P-9)
  factors_.settle();
  values_ = factors_.values();
  std::vector<Unknown> unknowns;
  for (const Block& block : blocks_) unknowns.push_back(block.unknown);
  P_ = factors_.covariance(unknowns);
  std::fill(turned_rad_.begin(), turned_rad_.end(), 0.0);
  ++relinearizations_;
}

Eigen::MatrixXd RecursivePorts::covariance(const std::vector<Unknown>& unknowns) const {
  std::vector<Eigen::Index> rows;
  for (const Unknown& unknown : unknowns) {
    for (Eigen::Index i = 0; i < rows_of(unknown.kind); ++i) rows.push_back(row_of_.at(unknown) + i);
  }
  return P_(rows, rows);
}

void RecursivePorts::resume(const std::deque<PortMap>& maps) {
  factors_.resume(maps);
  Eigen::Index rows = 0;
  row_of_.clear();
  for (const Block& block : blocks_) {
    if (block.row != rows || !values_.holds(block.unknown))
      throw InvalidArgument("block at row", static_cast<double>(block.row), "must follow the one before it and be of an unknown");
    row_of_[block.unknown] = block.row;
    rows += rows_of(block.unknown.kind);
  }
  if (P_.rows() != rows || P_.cols() != rows || turned_rad_.size() != values_.bases.size())
    throw InvalidArgument("covariance of the ports", static_cast<double>(P_.rows()), "must have the rows of its unknowns");
}

}  // namespace ssjs
