#include "ssjs/joining/closure.hpp"

#include <algorithm>

#include "ssjs/joining/closure_problem.hpp"

namespace ssjs {
namespace {

int dof_of(const Closure& closure) { return closure.from_T_to ? 3 : static_cast<int>(2 * closure.pairs.size()); }

}  // namespace

bool share_way(const Closure& a, const Closure& b) { return std::max(a.from, b.from) < std::min(a.to, b.to); }

ClosureFit fit(const Closure& closure, const LevelledChain& chain, const std::deque<PortMap>& maps) {
  const ClosureProblem problem({&closure}, chain, maps);
  return {problem.solve({0}).chi_squared, dof_of(closure), problem.off_m(0, problem.mean())};
}

CycleFit fit_cycle(const Closure& first, const Closure& second, const LevelledChain& chain, const std::deque<PortMap>& maps) {
  const ClosureProblem problem({&first, &second}, chain, maps);
  const ClosureProblem::Solution given_first = problem.solve({0});
  return {{given_first.chi_squared, dof_of(first), problem.off_m(0, problem.mean())},
          {problem.solve({1}).chi_squared, dof_of(second), problem.off_m(1, problem.mean())},
          problem.solve({0, 1}).chi_squared,
          problem.off_m(1, given_first.state)};
}

}  // namespace ssjs
