#include "ssjs/joining/sparse_solver.hpp"

#include <cholmod.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 20;
constexpr int kMaxHalvings = 8;
constexpr double kConvergedStep = 1e-9;      // m and rad, largest component
constexpr double kRelativeDecrease = 1e-10;  // of the cost

std::vector<Se2> ports_of(const PortFactor& factor, const std::vector<Se2>& poses) {
  std::vector<Se2> ports;
  for (const int port : factor.ports) ports.push_back(poses[static_cast<std::size_t>(port)]);
  return ports;
}

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
  std::vector<int> unknowns;          // base indices, ascending, without 0
  std::map<int, int> slot;            // base index -> position among the unknowns
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

  /// Names the unknowns and analyses the pattern of J' W J (lower triangle, 3 x 3 blocks) once for these factors.
  void prepare(const std::map<int, PortFactor>& factors) {
    clear();
    std::set<int> named;
    for (const auto& [base, port_factor] : factors) {
      named.insert(base);
      named.insert(port_factor.ports.begin(), port_factor.ports.end());
    }
    named.erase(0);
    unknowns.assign(named.begin(), named.end());
    slot.clear();
    for (std::size_t i = 0; i < unknowns.size(); ++i) slot[unknowns[i]] = static_cast<int>(i);
    std::vector<std::set<int>> below(unknowns.size());
    for (const auto& [base, port_factor] : factors) {
      const std::vector<int> touched = slots(port_factor);
      for (const int a : touched) {
        for (const int b : touched) {
          if (a >= 0 && b >= a) below[static_cast<std::size_t>(a)].insert(b);
        }
      }
    }
    std::size_t entries = 0;
    for (const auto& rows : below) entries += 9 * rows.size();
    const std::size_t n = 3 * unknowns.size();
    hessian = cholmod_allocate_sparse(n, n, entries, 1, 1, -1, CHOLMOD_REAL, &common);
    auto* column_start = static_cast<int*>(hessian->p);
    auto* row_index = static_cast<int*>(hessian->i);
    int entry = 0;
    block_start.assign(unknowns.size(), {});
    for (std::size_t column = 0; column < unknowns.size(); ++column) {
      for (int c = 0; c < 3; ++c) {
        column_start[3 * column + static_cast<std::size_t>(c)] = entry;
        for (const int row : below[column]) {
          if (c == 0) block_start[column][row] = entry;
          for (int r = 0; r < 3; ++r) row_index[entry++] = 3 * row + r;  // the upper part of a diagonal block is ignored (stype -1)
        }
      }
    }
    column_start[n] = entry;
    column_blocks.resize(unknowns.size());
    for (std::size_t column = 0; column < unknowns.size(); ++column) column_blocks[column] = static_cast<int>(below[column].size());
    factor = cholmod_analyze(hessian, &common);
  }

  std::vector<std::map<int, int>> block_start;  // per column of blocks: row of blocks -> first entry in its first column
  std::vector<int> column_blocks;

  [[nodiscard]] std::vector<int> slots(const PortFactor& port_factor) const {
    const auto slot_of = [&](int base) { return base == 0 ? -1 : slot.at(base); };
    std::vector<int> touched{slot_of(port_factor.base)};
    for (const int port : port_factor.ports) touched.push_back(slot_of(port));
    return touched;
  }

  /// Fills J' W J and J' W r at `poses`; returns half chi-squared.
  double linearize(const std::map<int, PortFactor>& factors, const std::vector<Se2>& poses) {
    auto* values = static_cast<double*>(hessian->x);
    std::fill(values, values + hessian->nzmax, 0.0);
    gradient.setZero(static_cast<Eigen::Index>(3 * unknowns.size()));
    double cost = 0.0;
    for (const auto& [base, port_factor] : factors) {
      const PortResidual at = port_residual(port_factor, poses[static_cast<std::size_t>(base)], ports_of(port_factor, poses));
      const Eigen::MatrixXd WJ = port_factor.information * at.J;
      const Eigen::MatrixXd JtWJ = at.J.transpose() * WJ;
      const Eigen::VectorXd JtWr = WJ.transpose() * at.residual;
      cost += 0.5 * at.residual.dot(port_factor.information * at.residual);
      const std::vector<int> touched = slots(port_factor);
      for (std::size_t a = 0; a < touched.size(); ++a) {
        if (touched[a] < 0) continue;
        gradient.segment<3>(3 * touched[a]) += JtWr.segment<3>(static_cast<Eigen::Index>(3 * a));
        const auto column = static_cast<std::size_t>(touched[a]);
        for (std::size_t b = 0; b < touched.size(); ++b) {
          if (touched[b] < touched[a]) continue;
          const int start = block_start[column].at(touched[b]);
          for (Eigen::Index c = 0; c < 3; ++c) {
            for (Eigen::Index r = 0; r < 3; ++r) {
              values[start + 3 * column_blocks[column] * static_cast<int>(c) + static_cast<int>(r)] +=
                  JtWJ(static_cast<Eigen::Index>(3 * b) + r, static_cast<Eigen::Index>(3 * a) + c);
            }
          }
        }
      }
    }
    return cost;
  }

  /// The covariance's columns of one base, solved for once per factor.
  const Eigen::MatrixXd& columns_of(int base) {
    auto found = columns.find(base);
    if (found == columns.end()) {
      Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * unknowns.size()), 3);
      unit.middleRows<3>(3 * slot.at(base)).setIdentity();
      found = columns.emplace(base, solve(unit)).first;
    }
    return found->second;
  }
  std::map<int, Eigen::MatrixXd> columns;

  void decompose() {
    columns.clear();
    cholmod_factorize(hessian, factor, &common);
    if (common.status != CHOLMOD_OK) {
      const std::size_t column = factor->minor < 3 * unknowns.size() ? factor->minor : 0;
      const auto original = static_cast<const int*>(factor->Perm)[column];
      throw NotPositiveDefinite("information matrix of the bases",
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

double SparsePoseSolver::optimize(const std::map<int, PortFactor>& factors, std::vector<Se2>& poses) {
  Implementation& self = *implementation_;
  self.prepare(factors);
  if (self.unknowns.empty()) return 0.0;
  double cost = self.linearize(factors, poses);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    self.decompose();
    const Eigen::VectorXd step = self.solve(-self.gradient);  // (J-16)
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
    const double decrease = cost - new_cost;
    cost = new_cost;
    if (step.lpNorm<Eigen::Infinity>() * scale < kConvergedStep || std::abs(decrease) <= kRelativeDecrease * (1.0 + cost)) break;
  }
  self.decompose();
  return cost;
}

Eigen::Matrix3d SparsePoseSolver::cross_covariance(int row_base, int column_base) const {
  if (row_base == 0 || column_base == 0) return Eigen::Matrix3d::Zero();
  Implementation& self = *implementation_;
  return self.columns_of(column_base).middleRows<3>(3 * self.slot.at(row_base));
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
