#include "ssjs/joining/sparse_solver.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/joining/sparse_cholesky.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 20;
constexpr int kMaxHalvings = 8;
constexpr std::size_t kMaxKeptColumns = 1000;  // of the covariance, 3 a base
constexpr double kRelativeDecrease = 1e-10;    // of the cost

}  // namespace

PortResidual port_residual(const PortFactor& factor, const Se2& global_T_base, const std::vector<Se2>& global_T_ports) {
  const auto n = static_cast<Eigen::Index>(global_T_ports.size());
  PortResidual result{Eigen::VectorXd(3 * n), Eigen::MatrixXd::Zero(3 * n, 3 * (n + 1))};
  for (Eigen::Index i = 0; i < n; ++i) {
    const RelativePose relative = relative_pose(global_T_base, global_T_ports[static_cast<std::size_t>(i)]);
    result.residual.segment<3>(3 * i) = additive_difference(relative.i_T_j, Se2::from_vector(factor.mean.segment<3>(3 * i)));  // (J-4)
    result.J.block<3, 3>(3 * i, 0) = relative.J_i;
    result.J.block<3, 3>(3 * i, 3 * (i + 1)) = relative.J_j;
  }
  return result;
}

struct SparsePoseSolver::Implementation {
  SparseCholesky hessian;
  std::vector<int> unknowns;  // base indices, ascending, without 0
  std::vector<int> slots;     // by base index: position among the unknowns, -1 for none
  Eigen::VectorXd gradient;
  std::map<int, Eigen::MatrixXd> columns;  // of the covariance, by base

  [[nodiscard]] int slot_of(int base) const {
    const int slot = base >= 0 && static_cast<std::size_t>(base) < slots.size() ? slots[static_cast<std::size_t>(base)] : -1;
    if (slot < 0) throw InvalidArgument("base", base, "is not among the bases of the factors");
    return slot;
  }

  /// Names the unknowns and analyses the pattern of J' W J (3 x 3 blocks) once for these factors.
  void prepare(const std::map<int, PortFactor>& factors) {
    columns.clear();
    int largest = 0;
    for (const auto& [base, port_factor] : factors) {
      largest = std::max(largest, base);
      for (const int port : port_factor.ports) largest = std::max(largest, port);
    }
    slots.assign(static_cast<std::size_t>(largest) + 1, -1);
    for (const auto& [base, port_factor] : factors) {
      slots[static_cast<std::size_t>(base)] = 0;
      for (const int port : port_factor.ports) slots[static_cast<std::size_t>(port)] = 0;
    }
    slots[0] = -1;
    unknowns.clear();
    for (std::size_t base = 0; base < slots.size(); ++base) {
      if (slots[base] < 0) continue;
      slots[base] = static_cast<int>(unknowns.size());
      unknowns.push_back(static_cast<int>(base));
    }
    std::vector<BlockPosition> blocks;
    for (const auto& [base, port_factor] : factors) {
      const std::vector<int> touched = touched_by(port_factor);
      for (const int a : touched) {
        for (const int b : touched) {
          if (b >= 0 && a >= b) blocks.emplace_back(a, b);
        }
      }
    }
    hessian.set_pattern(std::vector<int>(unknowns.size(), 3), blocks);
  }

  [[nodiscard]] std::vector<int> touched_by(const PortFactor& port_factor) const {
    std::vector<int> touched{slots[static_cast<std::size_t>(port_factor.base)]};
    for (const int port : port_factor.ports) touched.push_back(slots[static_cast<std::size_t>(port)]);
    return touched;
  }

  /// Fills J' W J and J' W r at `poses`; returns half chi-squared.
  double linearize(const std::map<int, PortFactor>& factors, const std::vector<Se2>& poses) {
    hessian.set_zero();
    gradient.setZero(static_cast<Eigen::Index>(3 * unknowns.size()));
    double cost = 0.0;
    std::vector<RelativePose> seen;
    for (const auto& [base, port_factor] : factors) {
      const Se2& global_T_base = poses[static_cast<std::size_t>(base)];
      const Eigen::MatrixXd& W = port_factor.information;
      const auto p = static_cast<Eigen::Index>(port_factor.ports.size());
      seen.clear();
      Eigen::VectorXd residual(3 * p);
      for (Eigen::Index i = 0; i < p; ++i) {
        seen.push_back(relative_pose(global_T_base, poses[static_cast<std::size_t>(port_factor.ports[static_cast<std::size_t>(i)])]));
        residual.segment<3>(3 * i) = additive_difference(seen.back().i_T_j, Se2::from_vector(port_factor.mean.segment<3>(3 * i)));  // (J-4)
      }
      const Eigen::VectorXd W_residual = W * residual;
      cost += 0.5 * residual.dot(W_residual);
      const int at_base = slots[static_cast<std::size_t>(base)];
      Eigen::Matrix3d base_block = Eigen::Matrix3d::Zero();
      for (Eigen::Index i = 0; i < p; ++i) {
        const RelativePose& row = seen[static_cast<std::size_t>(i)];
        const int at_i = slots[static_cast<std::size_t>(port_factor.ports[static_cast<std::size_t>(i)])];
        if (at_base >= 0) gradient.segment<3>(3 * at_base) += row.J_i.transpose() * W_residual.segment<3>(3 * i);
        if (at_i >= 0) gradient.segment<3>(3 * at_i) += row.J_j.transpose() * W_residual.segment<3>(3 * i);
        Eigen::Matrix3d port_base = Eigen::Matrix3d::Zero();  // rows of port i, columns of the base
        for (Eigen::Index j = 0; j < p; ++j) {
          const RelativePose& column = seen[static_cast<std::size_t>(j)];
          const Eigen::Matrix3d W_ij = W.block<3, 3>(3 * i, 3 * j);
          const Eigen::Matrix3d W_Ji = W_ij * column.J_i;
          base_block.noalias() += row.J_i.transpose() * W_Ji;
          port_base.noalias() += row.J_j.transpose() * W_Ji;
          const int at_j = slots[static_cast<std::size_t>(port_factor.ports[static_cast<std::size_t>(j)])];
          hessian.add<3, 3>(at_i, at_j, row.J_j.transpose() * W_ij * column.J_j);
        }
        if (at_i != at_base) {
          hessian.add<3, 3>(at_i, at_base, port_base);
          hessian.add<3, 3>(at_base, at_i, port_base.transpose());
        }
      }
      hessian.add<3, 3>(at_base, at_base, base_block);
    }
    return cost;
  }

  /// The covariance's columns of one base, solved for once per factor as far as memory is meant for them.
  const Eigen::MatrixXd& columns_of(int base) {
    auto found = columns.find(base);
    if (found == columns.end()) {
      if (columns.size() >= kMaxKeptColumns) columns.clear();
      Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * unknowns.size()), 3);
      unit.middleRows<3>(3 * slot_of(base)).setIdentity();
      found = columns.emplace(base, hessian.solve(unit)).first;
    }
    return found->second;
  }

  void decompose() {
    if (!hessian.all_finite()) {  // CHOLMOD lets NaN through
      throw NotPositiveDefinite("information matrix of the bases", "a port factor or a base is not finite");
    }
    columns.clear();
    if (const std::optional<int> loose = hessian.factorize()) {
      throw NotPositiveDefinite("information matrix of the bases",
                                "base " + std::to_string(unknowns[static_cast<std::size_t>(*loose)]) + " is not held by any port factor");
    }
  }
};

SparsePoseSolver::SparsePoseSolver() : implementation_(std::make_unique<Implementation>()) {}
SparsePoseSolver::~SparsePoseSolver() = default;
SparsePoseSolver::SparsePoseSolver(SparsePoseSolver&&) noexcept = default;
SparsePoseSolver& SparsePoseSolver::operator=(SparsePoseSolver&&) noexcept = default;

void SparsePoseSolver::factorize(const std::map<int, PortFactor>& factors, const std::vector<Se2>& poses) {
  implementation_->prepare(factors);
  if (implementation_->unknowns.empty()) return;
  implementation_->linearize(factors, poses);
  implementation_->decompose();
}

double SparsePoseSolver::optimize(const std::map<int, PortFactor>& factors, std::vector<Se2>& poses, double tolerance) {
  Implementation& self = *implementation_;
  self.prepare(factors);
  if (self.unknowns.empty()) return 0.0;
  double cost = self.linearize(factors, poses);
  self.decompose();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Eigen::VectorXd step = self.hessian.solve(-self.gradient);  // (J-16)
    if (-0.5 * step.dot(self.gradient) <= tolerance + kRelativeDecrease * cost) break;
    const std::vector<Se2> start = poses;
    double scale = 1.0;
    double new_cost = cost;
    for (int halving = 0; halving <= kMaxHalvings; ++halving, scale *= 0.5) {
      for (std::size_t i = 0; i < self.unknowns.size(); ++i) {
        const auto base = static_cast<std::size_t>(self.unknowns[i]);
        poses[base] = additive_step(start[base], scale * step.segment<3>(static_cast<Eigen::Index>(3 * i)));
      }
      new_cost = self.linearize(factors, poses);
      if (new_cost <= cost * (1.0 + kRelativeDecrease) + kRelativeDecrease) break;
    }
    self.decompose();
    const double decrease = cost - new_cost;
    cost = new_cost;
    if (std::abs(decrease) <= kRelativeDecrease * (1.0 + cost)) break;
  }
  return cost;
}

double SparsePoseSolver::factor_flops() const { return implementation_->hessian.factor_flops(); }
double SparsePoseSolver::factor_entries() const { return implementation_->hessian.factor_entries(); }

Eigen::Matrix3d SparsePoseSolver::cross_covariance(int row_base, int column_base) const {
  if (row_base == 0 || column_base == 0) return Eigen::Matrix3d::Zero();
  Implementation& self = *implementation_;
  return self.columns_of(column_base).middleRows<3>(3 * self.slot_of(row_base));
}

Eigen::MatrixXd SparsePoseSolver::covariance(const std::vector<int>& bases) const {
  const auto size = static_cast<Eigen::Index>(3 * bases.size());
  Eigen::MatrixXd joint(size, size);
  for (std::size_t j = 0; j < bases.size(); ++j) {
    for (std::size_t i = 0; i < bases.size(); ++i) {
      joint.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) = cross_covariance(bases[i], bases[j]);
    }
  }
  return 0.5 * (joint + joint.transpose());
}

}  // namespace ssjs
