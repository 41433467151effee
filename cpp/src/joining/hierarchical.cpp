#include "ssjs/joining/hierarchical.hpp"

#include "ssjs/joining/fusion.hpp"

namespace ssjs {
namespace {

constexpr int kMaxIterations = 10;

}  // namespace

bool HierarchicalJoiner::close_loop(int a, int b, const std::vector<Pair>& pairs, LoopAttempt& attempt) {
  // (H-2): the relative pose that the matches alone give; the maps stay as they are
  const Fusion match = fuse(maps().at(a), maps().at(b), pairs);
  attempt.chi_squared = match.chi_squared;
  attempt.dof = match.dof;
  if (!fits(attempt)) return false;
  mutable_links().observe(a, b, {match.map.base_T_pose(0), match.map.covariance.topLeftCorner<3, 3>()}, kMaxIterations);
  return true;
}

}  // namespace ssjs
