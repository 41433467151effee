#include "ssjs/joining/sparse_solver.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 20;
constexpr int kMaxHalvings = 8;
constexpr std::size_t kMaxKeptColumns = 1000;  // of the covariance, 3 a base
constexpr double kConvergedStep = 1e-6;        // m and rad, largest component; convergence is quadratic near the end
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
  cholmod_common common{};
  cholmod_sparse* hessian = nullptr;  // lower triangle
  cholmod_factor* factor = nullptr;
  std::vector<int> unknowns;  // base indices, ascending, without 0
  std::vector<int> slots;     // by base index: position among the unknowns, -1 for none
  Eigen::VectorXd gradient;

  Implementation() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SIMPLICIAL;  // the LGPL part, and deterministic
    common.final_ll = 1;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_AMD;
    common.postorder = 1;
    common.print = 0;
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;
  ~Implementation() {
    clear();
    cholmod_finish(&common);
  }
  void clear() {
    cholmod_free_sparse(&hessian, &common);
    cholmod_free_factor(&factor, &common);
  }

  [[nodiscard]] int slot_of(int base) const {
    const int slot = base >= 0 && static_cast<std::size_t>(base) < slots.size() ? slots[static_cast<std::size_t>(base)] : -1;
    if (slot < 0) throw InvalidArgument("base", base, "is not among the bases of the factors");
    return slot;
  }

  /// Names the unknowns and analyses the pattern of J' W J (lower triangle, 3 x 3 blocks) once for these factors.
  void prepare(const std::map<int, PortFactor>& factors) {
    clear();
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
    std::vector<std::vector<int>> below(unknowns.size());  // row blocks of every column of blocks
    for (const auto& [base, port_factor] : factors) {
      const std::vector<int> touched = touched_by(port_factor);
      for (const int a : touched) {
        if (a < 0) continue;
        for (const int b : touched) {
          if (b >= a) below[static_cast<std::size_t>(a)].push_back(b);
        }
      }
    }
    std::size_t entries = 0;
    for (auto& rows : below) {
      std::sort(rows.begin(), rows.end());
      rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
      entries += 9 * rows.size();
    }
    const std::size_t n = 3 * unknowns.size();
    hessian = cholmod_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_REAL, &common);
    auto* column_start = static_cast<int*>(hessian->p);
    auto* row_index = static_cast<int*>(hessian->i);
    int entry = 0;
    for (std::size_t column = 0; column < unknowns.size(); ++column) {
      for (int c = 0; c < 3; ++c) {
        column_start[3 * column + static_cast<std::size_t>(c)] = entry;
        for (const int row : below[column]) {
          for (int r = 0; r < 3; ++r) row_index[entry++] = 3 * row + r;  // the upper part of a diagonal block is ignored (stype -1)
        }
      }
    }
    column_start[n] = entry;
    row_blocks = std::move(below);
    factor = cholmod_analyze(hessian, &common);
  }
  std::vector<std::vector<int>> row_blocks;

  [[nodiscard]] std::vector<int> touched_by(const PortFactor& port_factor) const {
    std::vector<int> touched{slots[static_cast<std::size_t>(port_factor.base)]};
    for (const int port : port_factor.ports) touched.push_back(slots[static_cast<std::size_t>(port)]);
    return touched;
  }

  /// Adds a block of J' W J (rows of base a, columns of base b) where it falls into the lower triangle.
  void add(int a, int b, const Eigen::Matrix3d& block) {
    if (a < 0 || b < 0 || a < b) return;
    const std::vector<int>& rows = row_blocks[static_cast<std::size_t>(b)];
    const auto place = std::lower_bound(rows.begin(), rows.end(), a) - rows.begin();
    const auto height = static_cast<std::ptrdiff_t>(3 * rows.size());
    double* const first = static_cast<double*>(hessian->x) + static_cast<const int*>(hessian->p)[3 * b] + 3 * place;
    Eigen::Map<Eigen::Matrix3d, 0, Eigen::OuterStride<>>(first, Eigen::OuterStride<>(height)) += block;
  }

  /// Fills J' W J and J' W r at `poses`; returns half chi-squared.
  double linearize(const std::map<int, PortFactor>& factors, const std::vector<Se2>& poses) {
    auto* values = static_cast<double*>(hessian->x);
    std::fill(values, values + hessian->nzmax, 0.0);
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
          add(at_i, at_j, row.J_j.transpose() * W_ij * column.J_j);
        }
        if (at_i != at_base) {
          add(at_i, at_base, port_base);
          add(at_base, at_i, port_base.transpose());
        }
      }
      add(at_base, at_base, base_block);
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
      found = columns.emplace(base, solve(unit)).first;
    }
    return found->second;
  }
  std::map<int, Eigen::MatrixXd> columns;

  void decompose() {
    const auto* const values = static_cast<const double*>(hessian->x);
    if (!std::all_of(values, values + hessian->nzmax, [](double value) { return std::isfinite(value); })) {  // CHOLMOD lets NaN through
      throw NotPositiveDefinite("information matrix of the bases", "a port factor or a base is not finite");
    }
    columns.clear();
    cholmod_factorize(hessian, factor, &common);
    if (common.status != CHOLMOD_OK) {
      const std::size_t column = factor->minor < 3 * unknowns.size() ? factor->minor : 0;
      const auto original = static_cast<const int*>(factor->Perm)[column];
      throw NotPositiveDefinite(
          "information matrix of the bases",
          "base " + std::to_string(unknowns[static_cast<std::size_t>(original / 3)]) + " is not held by any port factor");
    }
  }

  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) {
    cholmod_dense view{};
    view.nrow = static_cast<std::size_t>(right.rows());
    view.ncol = static_cast<std::size_t>(right.cols());
    view.d = view.nrow;
    view.nzmax = view.nrow * view.ncol;
    view.x = const_cast<double*>(right.data());
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* answer = cholmod_solve(CHOLMOD_A, factor, &view, &common);
    Eigen::MatrixXd result = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(answer->x), right.rows(), right.cols());
    cholmod_free_dense(&answer, &common);
    return result;
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
    const Eigen::VectorXd step = self.solve(-self.gradient);  // (J-16)
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

double SparsePoseSolver::factor_flops() const { return implementation_->common.fl; }
double SparsePoseSolver::factor_entries() const { return implementation_->common.lnz; }

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
