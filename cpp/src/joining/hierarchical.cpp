#include "ssjs/joining/hierarchical.hpp"

#include <utility>

#include "ssjs/joining/fusion.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 10;

}  // namespace

void HierarchicalJoiner::close_loops(const NewMap& fresh, JoinReport& report) {
  std::vector<ObservedLink> observed;
  for (const int candidate : fresh.candidates) {
    LoopAttempt attempt = begun(fresh, candidate);
    const auto placement = [&] { return fresh.base_T_fresh[static_cast<std::size_t>(candidate)]; };
    if (const auto pairs = compare(candidate, fresh.base, placement, fresh.needed, attempt, report)) {
      // (H-2): the relative pose that the matches alone give; the maps stay as they are
      const Fusion match = fuse(maps().at(candidate), maps().at(fresh.base), *pairs);
      attempt.chi_squared = match.chi_squared;
      attempt.dof = match.dof;
      attempt.accepted = fits(attempt);
      if (attempt.accepted) observed.push_back({candidate, {match.map.base_T_pose(0), match.map.covariance.topLeftCorner<3, 3>()}});
    }
    report.loops.push_back(std::move(attempt));
  }
  mutable_links().observe(fresh.base, observed, kMaxIterations);  // all of them together
}

}  // namespace ssjs
