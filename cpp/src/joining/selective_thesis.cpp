#include "ssjs/joining/selective_thesis.hpp"

#include <algorithm>
#include <utility>

#include "ssjs/joining/fusion.hpp"

namespace ssjs {
namespace {

/// The map with one pose more in its state, taken for independent of everything in it.
LiveMap with_pose(const LiveMap& map, int base, const GaussianSe2& map_T_base) {
  LiveMap extended = map;
  const Eigen::Index n = map.mean.size();
  extended.poses = {base};
  extended.mean.resize(n + 3);
  extended.mean << map_T_base.mean.vector(), map.mean;
  extended.covariance.setZero(n + 3, n + 3);
  extended.covariance.topLeftCorner<3, 3>() = map_T_base.covariance;
  extended.covariance.bottomRightCorner(n, n) = map.covariance;
  return extended;
}

}  // namespace

void SelectiveThesisJoiner::close_loops(const NewMap& fresh, JoinReport& report) {
  int current = fresh.base;  // base of the map that holds the new submap
  bool links_have_moved = false;
  for (const int candidate : fresh.candidates) {
    LoopAttempt attempt = begun(fresh, candidate);
    const int a = std::min(candidate, current);
    const int b = std::max(candidate, current);
    const auto a_T_b = [&] { return links_have_moved ? links().relative(a, b) : fresh.base_T_fresh[static_cast<std::size_t>(a)]; };
    const auto pairs = compare(a, b, a_T_b, fresh.needed, attempt, report);
    attempt.accepted = pairs && merge(a, b, *pairs, attempt);
    if (attempt.accepted) {
      links_have_moved = true;
      current = a;
      ++report.fusions;
    }
    report.loops.push_back(std::move(attempt));
  }
}

bool SelectiveThesisJoiner::merge(int a, int b, const std::vector<Pair>& pairs, LoopAttempt& attempt) {
  const LiveMap& older = maps().at(a);
  const LiveMap& newer = maps().at(b);
  if (older.landmark_count() + newer.landmark_count() - attempt.pairs > config().max_fused_landmarks) {
    attempt.reason = "the fused map would be too large";
    return false;
  }
  Fusion fusion = fuse(with_pose(older, b, links().relative(a, b)), newer, pairs);  // (T-1): the chain's tau is a prior of the fusion
  attempt.chi_squared = fusion.chi_squared;
  attempt.dof = fusion.dof;
  if (!fits(attempt)) return false;
  const GaussianSe2 fused_link{fusion.map.base_T_pose(0), fusion.map.covariance.topLeftCorner<3, 3>()};
  mutable_links().observe(b, {{a, fused_link}}, 1);  // (T-2): and is in this observation of the chain again
  remove_poses(fusion.map, {0});
  set_ports(fusion.map, {});
  mutable_maps().erase(b);
  mutable_maps().insert_or_assign(a, std::move(fusion.map));
  return true;
}

}  // namespace ssjs
