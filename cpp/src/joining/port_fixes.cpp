#include "ssjs/joining/port_fixes.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Jacobian = Eigen::Matrix<double, 2, 3>;

struct Innovation {
  Eigen::Vector2d residual;
  Eigen::Matrix2d S;
  [[nodiscard]] double squared_distance() const { return residual.dot(S.llt().solve(residual)); }
};

Unknown base_of(const FixFactor& fix) { return {UnknownKind::kBase, fix.base}; }

/// What the fix says less what the survey knows. (P-32)
Innovation innovation(const FixFactor& fix, const PortLevel& level) {
  const PlacedFix placed = place_fix(level.values().base(fix.base), fix.base_p);
  const Eigen::Matrix3d P = level.covariance({base_of(fix)});
  return {fix.world_p - placed.world_p, placed.J_base * P * placed.J_base.transpose() + fix.covariance};
}

}  // namespace

FixAttempt PortFixes::take(const BaseFix& base_fix, int base, PortLevel& level, std::deque<PortMap>& maps) {
  const FixFactor fix{base, base_fix.base_p_vehicle, base_fix.fix.world_p_vehicle, base_fix.fix.covariance};
  FixAttempt attempt;
  attempt.time_s = base_fix.time_s;
  attempt.base = base;
  if (used_.empty()) {
    use(fix, level);
    level.settle();
    attempt.accepted = true;
    return attempt;
  }
  const Innovation of_fix = innovation(fix, level);
  attempt.chi_squared = of_fix.squared_distance();
  attempt.distance_m = of_fix.residual.norm();
  attempt.accepted = *attempt.chi_squared <= chi_squared_quantile(config_.gate_probability, 2.0);  // (P-32)
  if (attempt.accepted) {
    suspects_.clear();
    use(fix, level);
    level.settle();
    return attempt;
  }
  if (base_fix.fix.set_pose || !agrees_with_suspects(fix, level)) suspects_.clear();
  suspects_.push_back(fix);
  if (base_fix.fix.set_pose || static_cast<int>(suspects_.size()) >= config_.relocate_after) {
    relocate(level, maps);
    attempt.accepted = attempt.relocated = true;
    return attempt;
  }
  attempt.reason = "outside the gate";
  return attempt;
}

void PortFixes::use(const FixFactor& fix, PortLevel& level) {
  if (used_.empty()) level.free_start({config_.start_heading_sigma_rad * config_.start_heading_sigma_rad});  // (P-31)
  level.fix(fix);
  used_.push_back(fix);
}

void PortFixes::put_into(PortLevel& level) const {
  if (!used_.empty()) level.free_start({config_.start_heading_sigma_rad * config_.start_heading_sigma_rad});
  for (const FixFactor& fix : used_) level.fix(fix);
}

/// The way between the two fixes is as the survey knows it, wherever it lies. (P-33)
bool PortFixes::agrees_with_suspects(const FixFactor& fix, const PortLevel& level) const {
  if (suspects_.empty()) return true;
  const FixFactor& first = suspects_.front();
  const PlacedFix there = place_fix(level.values().base(first.base), first.base_p);
  const PlacedFix here = place_fix(level.values().base(fix.base), fix.base_p);
  Eigen::Matrix<double, 2, 6> J;
  J << -there.J_base, here.J_base;
  const Innovation between{fix.world_p - first.world_p - (here.world_p - there.world_p),
                           J * level.covariance({base_of(first), base_of(fix)}) * J.transpose() + first.covariance + fix.covariance};
  return between.squared_distance() <= chi_squared_quantile(config_.gate_probability, 2.0);
}

void PortFixes::relocate(PortLevel& level, std::deque<PortMap>& maps) {
  const FixFactor& first = suspects_.front();
  const Innovation of_first = innovation(first, level);
  PortMap& broken = maps[static_cast<std::size_t>(first.base - 1)];
  loosen_exit(broken.submap, missing_variance(of_first.residual, of_first.S));
  level.loosen(broken);
  for (const FixFactor& fix : suspects_) use(fix, level);
  level.settle();
  suspects_.clear();
}

void loosen_exit(LevelledSubmap& submap, double variance) {
  for (LevelledStep& step : submap.steps) {
    const Eigen::Index n = step.gain.cols();
    const Eigen::MatrixXd P = submap.covariance.topLeftCorner(n, n);
    Eigen::MatrixXd looser = P;
    looser.topLeftCorner<2, 2>().diagonal().array() += variance;
    const Eigen::LLT<Eigen::MatrixXd> factor(looser);
    const Eigen::MatrixXd with_exit = step.gain * P;  // Cov(step, entries)
    const Eigen::MatrixXd gain = factor.solve(with_exit.transpose()).transpose();
    step.conditional_covariance += with_exit * (step.gain - gain).transpose();
    step.conditional_covariance = (0.5 * (step.conditional_covariance + step.conditional_covariance.transpose())).eval();
    step.gain = gain;
  }
  submap.covariance.topLeftCorner<2, 2>().diagonal().array() += variance;
}

double missing_variance(const Eigen::Vector2d& residual, const Eigen::Matrix2d& S) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(S);
  const Eigen::Vector2d along = axes.eigenvectors().transpose() * residual;
  const auto distance = [&](double v) { return (along.array().square() / (axes.eigenvalues().array() + v)).sum(); };
  double low = 0.0;
  if (distance(low) <= 2.0) return low;
  double high = 0.5 * residual.squaredNorm();  // there it is at most 2, S being positive definite
  for (int i = 0; i < 100 && high - low > 1e-9 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (distance(middle) > 2.0 ? low : high) = middle;
  }
  return high;
}

}  // namespace ssjs
