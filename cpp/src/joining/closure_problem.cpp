#include "ssjs/joining/closure_problem.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 10;
constexpr double kSettled = 1e-6;  // m and rad

/// The landmarks of each map that closures name.
std::map<int, std::set<Eigen::Index>> named_landmarks(const std::vector<const Closure*>& closures) {
  std::map<int, std::set<Eigen::Index>> named;
  for (const Closure* const closure : closures) {
    named[closure->from];
    named[closure->to];
    for (const auto& [of_from, of_to] : closure->pairs) {
      named[closure->from].insert(of_from);
      named[closure->to].insert(of_to);
    }
  }
  return named;
}

void append(Eigen::VectorXd& mean, Eigen::MatrixXd& covariance, const Eigen::VectorXd& more, const Eigen::MatrixXd& P) {
  const Eigen::Index n = mean.size();
  const Eigen::Index m = more.size();
  mean.conservativeResize(n + m);
  mean.tail(m) = more;
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(n + m, n + m);
  joint.topLeftCorner(n, n) = covariance;
  joint.bottomRightCorner(m, m) = P;
  covariance = std::move(joint);
}

}  // namespace

ClosureProblem::ClosureProblem(const std::vector<const Closure*>& closures, const LevelledChain& chain, const std::deque<PortMap>& maps)
    : closures_(closures) {
  const std::map<int, std::set<Eigen::Index>> named = named_landmarks(closures);
  for (const auto& [base, landmarks] : named) bases_.push_back(base);
  for (std::size_t i = 0; i < bases_.size(); ++i) {
    const int base = bases_[i];
    const bool is_last = i + 1 == bases_.size();
    const std::set<Eigen::Index>& landmarks = named.at(base);
    if (is_last && landmarks.empty()) continue;
    const LevelledSubmap& submap = maps[static_cast<std::size_t>(base)].submap;
    std::vector<Eigen::Index> rows;
    for (const Eigen::Index landmark : landmarks) {
      rows.push_back(submap.landmark_offset(landmark));
      rows.push_back(submap.landmark_offset(landmark) + 1);
    }
    const Stretch stretch = chain.between(base, is_last ? base : bases_[i + 1], submap, rows);
    std::vector<Eigen::Index> used;
    pose_.push_back(mean_.size());
    if (!is_last) used = {0, 1, 2};
    Eigen::Index row = mean_.size() + (is_last ? 0 : 3);
    for (const Eigen::Index landmark : landmarks) {
      landmark_[{base, landmark}] = row;
      row += 2;
    }
    for (Eigen::Index extra = stretch.extra(); extra < stretch.mean.size(); ++extra) used.push_back(extra);
    append(mean_, covariance_, stretch.mean(used), stretch.covariance(used, used));
  }
}

ClosureProblem::Residual ClosureProblem::residual(std::size_t nth, const Eigen::VectorXd& state) const {
  const Closure& closure = *closures_[nth];
  const auto place = [&](int base) {
    return static_cast<std::size_t>(std::lower_bound(bases_.begin(), bases_.end(), base) - bases_.begin());
  };
  const std::size_t from = place(closure.from);
  const std::size_t to = place(closure.to);
  const auto step = [&](std::size_t i) { return Se2::from_vector(state.segment<3>(pose_[i])); };
  Se2 from_T_to;  // (C-3)
  for (std::size_t i = from; i < to; ++i) from_T_to = from_T_to * step(i);
  Eigen::MatrixXd J_pose = Eigen::MatrixXd::Zero(3, state.size());
  Se2 before;
  for (std::size_t i = from; i < to; ++i) {
    const Se2 after = (before * step(i)).inverse() * from_T_to;
    J_pose.middleCols<3>(pose_[i]) = compose_jacobian_right(before) * compose_jacobian_left(step(i), after);
    before = before * step(i);
  }
  if (closure.from_T_to) return {additive_difference(from_T_to, closure.from_T_to->mean), J_pose, closure.from_T_to->covariance};
  const auto rows = static_cast<Eigen::Index>(2 * closure.pairs.size());
  Residual residual{Eigen::VectorXd(rows), Eigen::MatrixXd::Zero(rows, state.size()), Eigen::MatrixXd::Zero(rows, rows)};
  Eigen::Index row = 0;
  for (const auto& [of_from, of_to] : closure.pairs) {
    const Eigen::Index m = landmark_.at({closure.from, of_from});
    const Eigen::Index n = landmark_.at({closure.to, of_to});
    const Eigen::Vector2d to_p = state.segment<2>(n);
    residual.r.segment<2>(row) = from_T_to * to_p - state.segment<2>(m);  // (C-4)
    residual.J.middleRows<2>(row) = act_jacobian(from_T_to, to_p) * J_pose;
    residual.J.block<2, 2>(row, n) += from_T_to.rotation();
    residual.J.block<2, 2>(row, m) -= Eigen::Matrix2d::Identity();
    row += 2;
  }
  return residual;
}

double ClosureProblem::off_m(std::size_t nth, const Eigen::VectorXd& state) const {
  const Eigen::VectorXd r = residual(nth, state).r;
  if (closures_[nth]->from_T_to) return r.head<2>().norm();
  return r.norm() / std::sqrt(static_cast<double>(closures_[nth]->pairs.size()));
}

ClosureProblem::Residual ClosureProblem::stacked(const std::vector<std::size_t>& closures, const Eigen::VectorXd& state) const {
  Residual all{Eigen::VectorXd(0), Eigen::MatrixXd(0, state.size()), Eigen::MatrixXd(0, 0)};
  for (const std::size_t nth : closures) {
    const Residual one = residual(nth, state);
    append(all.r, all.noise, one.r, one.noise);
    all.J.conservativeResize(all.r.size(), Eigen::NoChange);
    all.J.bottomRows(one.r.size()) = one.J;
  }
  return all;
}

ClosureProblem::Solution ClosureProblem::solve(const std::vector<std::size_t>& closures) const {
  Solution solution{mean_, 0.0};
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Residual at = stacked(closures, solution.state);
    const Eigen::MatrixXd PJt = covariance_ * at.J.transpose();
    const Eigen::MatrixXd L = cholesky_lower(at.J * PJt + at.noise, "covariance of a closure", "its own and that of the way");
    Eigen::VectorXd white = at.r + at.J * (mean_ - solution.state);
    L.triangularView<Eigen::Lower>().solveInPlace(white);
    solution.chi_squared = white.squaredNorm();  // (C-5)
    const Eigen::VectorXd next = mean_ - PJt * L.transpose().triangularView<Eigen::Upper>().solve(white);
    const double moved = (next - solution.state).cwiseAbs().maxCoeff();
    solution.state = next;
    if (moved <= kSettled) break;
  }
  return solution;
}

}  // namespace ssjs
