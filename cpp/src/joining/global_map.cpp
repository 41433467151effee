#include "ssjs/joining/global_map.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

Eigen::Index position(const std::vector<int>& bases, int base) {
  const auto found = std::find(bases.begin(), bases.end(), base);
  if (found == bases.end()) throw InvalidArgument("base", static_cast<double>(base), "is not a live base of the global map");
  return found - bases.begin();
}

constexpr double kOnlineTolerance = 1e-4;  // of half chi-squared: a hundredth of a standard deviation
constexpr double kFinalTolerance = 1e-9;
constexpr double kHysteresis = 1.5;
constexpr std::size_t kMaxDenseBases = 2000;  // 288 MB

Eigen::Index whole_tiles(Eigen::Index n) { return (n + 3) / 4 * 4; }  // of SymmetricDowndate

/// The 3 x 3 blocks of these rows and columns, out of the lower triangle.
template <class Rows, class Matrix>
void copy_blocks(const Eigen::MatrixXd& lower, const Rows& rows, Matrix& joint) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto at_i = static_cast<Eigen::Index>(3 * i);
    joint.template block<3, 3>(at_i, at_i) = lower.block<3, 3>(rows[i], rows[i]).template selfadjointView<Eigen::Lower>();
    for (std::size_t j = 0; j < i; ++j) {
      const auto at_j = static_cast<Eigen::Index>(3 * j);
      Eigen::Matrix3d cross;
      if (rows[i] > rows[j]) {
        cross = lower.block<3, 3>(rows[i], rows[j]);
      } else {
        cross = lower.block<3, 3>(rows[j], rows[i]).transpose();
      }
      joint.template block<3, 3>(at_i, at_j) = cross;
      joint.template block<3, 3>(at_j, at_i) = cross.transpose();
    }
  }
}

/// P <- M P M' with M(X_i) of (S-8) for each block of three; a negative sign undoes it.
template <class Matrix, class Poses>
void leave_invariant_frame(Matrix& P, const Poses& X, double sign = 1.0) {
  for (std::size_t i = 0; i < X.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    P.row(at) -= sign * X[i].y * P.row(at + 2);
    P.row(at + 1) += sign * X[i].x * P.row(at + 2);
  }
  for (std::size_t i = 0; i < X.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    P.col(at) -= sign * X[i].y * P.col(at + 2);
    P.col(at + 1) += sign * X[i].x * P.col(at + 2);
  }
}

}  // namespace

GlobalMap::GlobalMap(GlobalSolver solver, int dense_bases)
    : always_sparse_(solver == GlobalSolver::kGaussNewton),
      sparse_(always_sparse_),
      next_comparison_(static_cast<std::size_t>(dense_bases)),
      poses_{Se2{}},
      live_{0},
      P_(Eigen::MatrixXd::Zero(4, 4)) {}

void GlobalMap::set_factor(const LiveMap& map) {
  factors_[map.base] = {map.base, {map.poses.begin(), map.poses.begin() + map.ports}, map.mean.head(map.port_size()), map.port_information};
}

void GlobalMap::attach(const LiveMap& map) {
  const int next = map.poses.front();
  const GaussianSe2 base_T_next{map.base_T_pose(0), map.covariance.topLeftCorner<3, 3>()};
  poses_.resize(static_cast<std::size_t>(next) + 1);
  const Se2& global_T_base = pose(map.base);
  poses_[static_cast<std::size_t>(next)] = global_T_base * base_T_next.mean;
  set_factor(map);
  if (sparse_) {
    if (!stale_) extend_tail(map);
  } else {  // (J-5): the exit pose is independent of everything before it
    const Eigen::Index n = 3 * static_cast<Eigen::Index>(live_.size());
    if (P_.rows() < whole_tiles(n + 3)) P_.conservativeResize(whole_tiles(2 * (n + 3)), whole_tiles(2 * (n + 3)));
    const Eigen::Index at = 3 * position(live_, map.base);
    const Eigen::MatrixXd columns = dense_columns({at});
    Eigen::Matrix3d own = turned(global_T_base.rotation(), base_T_next.covariance);
    leave_invariant_frame(own, std::array{pose(next)}, -1.0);
    P_.block(n, 0, 3, n) = columns.transpose();  // an invariant error passes on unchanged: M(X_next)^-1 J1 M(X_base) = I
    P_.block<3, 3>(n, n) = columns.middleRows<3>(at) + own;
  }
  live_.push_back(next);
  if (sparse_ || live_.size() <= next_comparison_) return;
  sparse_solver_.factorize(factors_, poses_);
  if (sparse_work() < dense_work()) {
    go_sparse();
    stale_ = false;
  } else {
    next_comparison_ = live_.size() + live_.size() / 10;
  }
}

void GlobalMap::replace(int a, int b, const LiveMap& joined, const JoinEvidence& evidence, const std::vector<const LiveMap*>& changed) {
  if (!sparse_) correct(evidence);
  factors_.erase(a);
  factors_.erase(b);
  set_factor(joined);
  for (const LiveMap* const map : changed) set_factor(*map);
  forget_unused_bases();
  pending_ = sparse_;
}

void GlobalMap::settle() {
  if (!pending_) return;
  pending_ = false;
  sparse_solver_.optimize(factors_, poses_, kOnlineTolerance);
  tail_.clear();
  stale_ = false;
  if (!always_sparse_ && sparse_work() > kHysteresis * dense_work() && live_.size() <= kMaxDenseBases) go_dense();
}

double GlobalMap::sparse_work() const { return 20.0 * sparse_solver_.factor_flops() + 400.0 * sparse_solver_.factor_entries(); }
double GlobalMap::dense_work() const { return 13.0 * std::pow(3.0 * static_cast<double>(live_.size()), 2); }

void GlobalMap::extend_tail(const LiveMap& map) {
  const GaussianSe2 base_T_next{map.base_T_pose(0), map.covariance.topLeftCorner<3, 3>()};
  const Eigen::Matrix3d J1 = compose_jacobian_left(pose(map.base), base_T_next.mean);
  const Eigen::Matrix3d J2 = compose_jacobian_right(pose(map.base));
  const Eigen::Matrix3d own = J2 * base_T_next.covariance * J2.transpose();
  if (tail_.empty()) {
    anchor_ = map.base;
    tail_.push_back({map.poses.front(), J1, own});
  } else {
    tail_.push_back({map.poses.front(), J1 * tail_.back().to_anchor, J1 * tail_.back().noise * J1.transpose() + own});
  }
}

Eigen::Matrix3d GlobalMap::sparse_cross_covariance(int row_base, int column_base) const {
  const auto in_tail = [&](int base) {
    const auto found = std::lower_bound(tail_.begin(), tail_.end(), base, [](const TailBase& link, int b) { return link.base < b; });
    return found != tail_.end() && found->base == base ? &*found : nullptr;
  };
  const TailBase* const row = in_tail(row_base);
  const TailBase* const column = in_tail(column_base);
  Eigen::Matrix3d cross = sparse_solver_.cross_covariance(row != nullptr ? anchor_ : row_base, column != nullptr ? anchor_ : column_base);
  if (row != nullptr) cross = (row->to_anchor * cross).eval();
  if (column != nullptr) cross = (cross * column->to_anchor.transpose()).eval();
  if (row == nullptr || column == nullptr) return cross;
  // the later one carries the earlier one's noise on: Phi = to_anchor(later) * to_anchor(earlier)^-1
  if (row_base <= column_base) {
    const Eigen::Matrix3d Phi = column->to_anchor * row->to_anchor.inverse();
    return cross + row->noise * Phi.transpose();
  }
  const Eigen::Matrix3d Phi = row->to_anchor * column->to_anchor.inverse();
  return cross + Phi * column->noise;
}

Eigen::MatrixXd GlobalMap::dense_columns(const std::vector<Eigen::Index>& blocks) const {
  const Eigen::Index n = 3 * static_cast<Eigen::Index>(live_.size());
  Eigen::MatrixXd columns(n, static_cast<Eigen::Index>(3 * blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Eigen::Index at = blocks[i];
    auto own = columns.middleCols<3>(static_cast<Eigen::Index>(3 * i));
    own.topRows(at) = P_.block(at, 0, 3, at).transpose();
    own.middleRows<3>(at) = P_.block<3, 3>(at, at).selfadjointView<Eigen::Lower>();
    own.bottomRows(n - at - 3) = P_.block(at + 3, at, n - at - 3, 3);
  }
  return columns;
}

void GlobalMap::correct(const JoinEvidence& evidence) {
  const Eigen::Index rows = evidence.residual.size();
  std::vector<Eigen::Index> blocks;
  Eigen::MatrixXd H = evidence.J;  // (J-15): of invariant errors, H = J M
  for (std::size_t i = 0; i < evidence.bases.size(); ++i) {
    blocks.push_back(3 * position(live_, evidence.bases[i]));
    const Se2& X = pose(evidence.bases[i]);
    auto own = H.middleCols<3>(static_cast<Eigen::Index>(3 * i));
    own.col(2) += X.x * own.col(1) - X.y * own.col(0);
  }
  Eigen::MatrixXd Y = dense_columns(blocks) * H.transpose();
  Eigen::MatrixXd HPt(H.cols(), rows);
  for (std::size_t i = 0; i < blocks.size(); ++i) HPt.middleRows<3>(static_cast<Eigen::Index>(3 * i)) = Y.middleRows<3>(blocks[i]);
  Eigen::MatrixXd S = evidence.noise;
  S.noalias() += H * HPt;
  const Eigen::MatrixXd L = cholesky_lower(S, "innovation covariance of the bases", "map-to-map pairing");
  for (Eigen::Index j = 0; j < rows; ++j) {  // Y = P H' L^-T
    for (Eigen::Index i = 0; i < j; ++i) Y.col(j) -= L(j, i) * Y.col(i);
    Y.col(j) *= 1.0 / L(j, j);
  }
  const Eigen::VectorXd step = -Y * L.triangularView<Eigen::Lower>().solve(evidence.residual);  // (J-14)
  downdate_(Y, P_);
  for (std::size_t i = 0; i < live_.size(); ++i) {  // (J-15)
    Se2& X = poses_[static_cast<std::size_t>(live_[i])];
    X = se2_exp(step.segment<3>(static_cast<Eigen::Index>(3 * i))) * X;
  }
}

void GlobalMap::forget_unused_bases() {
  std::vector<bool> is_used(poses_.size(), false);
  is_used[0] = true;
  for (const auto& [base, factor] : factors_) {
    is_used[static_cast<std::size_t>(base)] = true;
    for (const int port : factor.ports) is_used[static_cast<std::size_t>(port)] = true;
  }
  for (std::size_t i = live_.size(); i-- > 0;) {
    if (is_used[static_cast<std::size_t>(live_[i])]) continue;
    if (!sparse_) {  // marginalise: the last base takes its rows and columns
      const auto last = static_cast<Eigen::Index>(3 * (live_.size() - 1));
      const auto at = static_cast<Eigen::Index>(3 * i);
      if (at != last) {
        P_.block(at, 0, 3, at) = P_.block(last, 0, 3, at);
        P_.block<3, 3>(at, at) = P_.block<3, 3>(last, last);
        P_.block(at + 3, at, last - at - 3, 3) = P_.block(last, at + 3, 3, last - at - 3).transpose();
      }
    }
    live_[i] = live_.back();
    live_.pop_back();
  }
}

void GlobalMap::go_sparse() {
  sparse_ = true;
  P_.resize(0, 0);
  tail_.clear();
  stale_ = true;
}

void GlobalMap::go_dense() {
  Eigen::MatrixXd P = covariance(live_);
  std::vector<Se2> X;
  for (const int base : live_) X.push_back(pose(base));
  leave_invariant_frame(P, X, -1.0);
  const Eigen::Index n = P.rows();
  P_.resize(whole_tiles(n), whole_tiles(n));
  P_.topLeftCorner(n, n) = P;
  sparse_ = false;
  next_comparison_ = live_.size() + live_.size() / 10;
}

void GlobalMap::relinearize() {
  if (!sparse_) go_sparse();
  pending_ = false;
  sparse_solver_.optimize(factors_, poses_, kFinalTolerance);
  tail_.clear();
  stale_ = false;
}

void GlobalMap::refresh() const {
  if (!stale_) return;
  sparse_solver_.factorize(factors_, poses_);
  stale_ = false;
}

Matrix6d GlobalMap::covariance_bound(int base, int newest) const {
  if (!sparse_) return covariance(base, newest);
  refresh();
  auto marginal = known_marginal_.find(base);
  if (marginal == known_marginal_.end()) marginal = known_marginal_.emplace(base, sparse_cross_covariance(base, base)).first;
  const Eigen::Matrix3d cross = sparse_cross_covariance(base, newest);
  Matrix6d joint;
  joint << marginal->second, cross, cross.transpose(), sparse_cross_covariance(newest, newest);
  return joint;
}

Matrix6d GlobalMap::covariance(int base, int other) const {
  if (sparse_) return covariance(std::vector<int>{base, other});
  Matrix6d joint;
  copy_blocks(P_, std::array{3 * position(live_, base), 3 * position(live_, other)}, joint);
  leave_invariant_frame(joint, std::array{pose(base), pose(other)});
  return joint;
}

Eigen::MatrixXd GlobalMap::covariance(const std::vector<int>& bases) const {
  if (sparse_) {
    refresh();
    Eigen::MatrixXd joint(3 * bases.size(), 3 * bases.size());
    for (std::size_t i = 0; i < bases.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const Eigen::Matrix3d cross = sparse_cross_covariance(bases[i], bases[j]);
        joint.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) = cross;
        joint.block<3, 3>(static_cast<Eigen::Index>(3 * j), static_cast<Eigen::Index>(3 * i)) = cross.transpose();
      }
      known_marginal_[bases[i]] = joint.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * i));
    }
    return joint;
  }
  std::vector<Eigen::Index> rows;
  std::vector<Se2> X;
  for (const int base : bases) {
    rows.push_back(3 * position(live_, base));
    X.push_back(pose(base));
  }
  Eigen::MatrixXd joint(3 * bases.size(), 3 * bases.size());
  copy_blocks(P_, rows, joint);
  leave_invariant_frame(joint, X);
  return joint;
}

}  // namespace ssjs
