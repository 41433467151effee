#include "ssjs/joining/closure_guard.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/joining/consistent_set.hpp"

namespace ssjs {
namespace {

constexpr double kGrantedWeight = 1e6;  // more than any proposals together
constexpr double kTieBreak = 1e-3;      // of a closure's weight: of two of one weight the one that fits the way better

std::string text(const char* format, double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string off_by(const ClosureFit& fit) {
  return "off by " + text("%.1f", fit.off_m) + " m, chi-squared " + text("%.0f", fit.chi_squared) + " of " + std::to_string(fit.dof) +
         " dof";
}

/// Maps along the way between the ends of both.
int distance(const Closure& a, const Closure& b) { return std::abs(a.from - b.from) + std::abs(a.to - b.to); }

}  // namespace

std::size_t ClosureGuard::add(const Closure& closure, double weight, ClosureStanding standing, const std::deque<PortMap>& maps) {
  const std::size_t nth = closures_.size();
  closures_.push_back({closure, weight, standing, {}});
  stands_.push_back(true);
  if (!config_.enabled) return nth;
  if (standing == ClosureStanding::kProposed) {
    ++proposals_;
    Judged& judged = closures_.back();
    judged.alone = fit(closure, chain_, maps);
    judged.against_the_way = !fits(*judged.alone);
    stands_.back() = !judged.against_the_way;
    if (judged.against_the_way) return nth;
  }
  if (proposals_ == 0) return nth;  // nothing is in doubt
  for (const std::size_t partner : partners_of(nth)) compare(partner, nth, maps);
  return nth;
}

bool ClosureGuard::fits(const ClosureFit& fit) const { return fit.chi_squared <= chi_squared_quantile(config_.gate_probability, fit.dof); }

/// In the order of their numbers.
std::vector<std::size_t> ClosureGuard::nearest(std::vector<std::pair<int, std::size_t>> by_distance) const {
  const std::size_t count = std::min(by_distance.size(), static_cast<std::size_t>(config_.max_partners));
  std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(count), by_distance.end());
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < count; ++i) nearest.push_back(by_distance[i].second);
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

std::vector<std::size_t> ClosureGuard::partners_of(std::size_t nth) const {
  const Judged& own = closures_[nth];
  std::vector<std::pair<int, std::size_t>> near;
  for (std::size_t i = 0; i < nth; ++i) {
    const Judged& other = closures_[i];
    const bool doubtful = own.standing == ClosureStanding::kProposed || other.standing == ClosureStanding::kProposed;
    if (!doubtful || other.against_the_way || !share_way(own.closure, other.closure)) continue;
    near.emplace_back(distance(own.closure, other.closure), i);
  }
  return nearest(std::move(near));
}

std::vector<std::size_t> ClosureGuard::all_poses() const {
  std::vector<std::size_t> poses;
  for (std::size_t i = 0; i < closures_.size(); ++i) {
    const Judged& judged = closures_[i];
    if (judged.standing == ClosureStanding::kProposed && judged.closure.from_T_to && !judged.against_the_way) poses.push_back(i);
  }
  return poses;
}

std::vector<std::size_t> ClosureGuard::poses_near(std::size_t closure) const {
  std::vector<std::pair<int, std::size_t>> near;
  for (const std::size_t i : all_poses()) {
    if (share_way(closures_[closure].closure, closures_[i].closure)) {
      near.emplace_back(distance(closures_[closure].closure, closures_[i].closure), i);
    }
  }
  return nearest(std::move(near));
}

void ClosureGuard::judge_by_the_rest(std::size_t closure, const ClosureFit& fit) {
  closures_[closure].against_the_rest.reset();
  if (!fits(fit)) closures_[closure].against_the_rest = fit;
  is_stale_ = true;
}

void ClosureGuard::compare(std::size_t a, std::size_t b, const std::deque<PortMap>& maps) {
  const CycleFit cycle = fit_cycle(closures_[a].closure, closures_[b].closure, chain_, maps);
  const bool agree = cycle.second_given_first() <= chi_squared_quantile(config_.gate_probability, cycle.second.dof) &&
                     cycle.first_given_second() <= chi_squared_quantile(config_.gate_probability, cycle.first.dof);  // (C-6)
  if (agree) return;
  contradictions_.push_back({a, b, {cycle.second_given_first(), cycle.second.dof, cycle.off_m}});
  is_stale_ = true;
}

void ClosureGuard::resolve() {
  if (!is_stale_) return;
  is_stale_ = false;
  std::vector<double> weights;
  for (const Judged& judged : closures_) {
    if (judged.standing == ClosureStanding::kGranted) {
      weights.push_back(kGrantedWeight * judged.weight);
      continue;
    }
    const double fits = judged.alone ? 1.0 - chi_squared_cdf(judged.alone->chi_squared, judged.alone->dof) : 1.0;
    weights.push_back(judged.weight * (1.0 + kTieBreak * fits));  // (C-9)
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const Contradiction& contradiction : contradictions_) {
    if (!is_doubted(contradiction.a) && !is_doubted(contradiction.b)) pairs.emplace_back(contradiction.a, contradiction.b);
  }
  const ConsistentSet set = heaviest_consistent_set(weights, pairs, config_.node_budget);
  exact_ = set.exact;
  for (std::size_t i = 0; i < closures_.size(); ++i) stands_[i] = set.kept[i] && !closures_[i].against_the_way && !is_doubted(i);
}

bool ClosureGuard::stands(std::size_t closure) {
  resolve();
  return stands_[closure];
}

std::string ClosureGuard::reason(std::size_t closure) {
  if (stands(closure)) return {};
  const Judged& judged = closures_[closure];
  if (judged.against_the_way) {
    return "contradicts the way from map " + std::to_string(judged.closure.from) + " to map " + std::to_string(judged.closure.to) + ": " +
           off_by(*judged.alone);
  }
  if (judged.against_the_rest) {
    return "contradicts what all other closures and the way say of maps " + std::to_string(judged.closure.from) + " and " +
           std::to_string(judged.closure.to) + ": " + off_by(*judged.against_the_rest);
  }
  int against = 0;
  const Contradiction* worst = nullptr;
  for (const Contradiction& contradiction : contradictions_) {
    if (contradiction.a != closure && contradiction.b != closure) continue;
    if (!stands_[contradiction.a == closure ? contradiction.b : contradiction.a]) continue;
    ++against;
    if (worst == nullptr || contradiction.fit.chi_squared > worst->fit.chi_squared) worst = &contradiction;
  }
  if (worst == nullptr) return "outweighed by closures that agree with each other";
  const Closure& other = closures_[worst->a == closure ? worst->b : worst->a].closure;
  const auto map = [](int base) { return std::to_string(base); };
  return "contradicts " + std::to_string(against) + (against == 1 ? " closure" : " closures that agree with each other") +
         ": cycle through maps " + map(judged.closure.from) + ", " + map(judged.closure.to) + ", " + map(other.to) + ", " +
         map(other.from) + " " + off_by(worst->fit);
}

}  // namespace ssjs
