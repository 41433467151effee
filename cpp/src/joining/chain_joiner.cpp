#include "ssjs/joining/chain_joiner.hpp"

#include <utility>

namespace ssjs {

ChainJoiner::ChainJoiner(MapAssociator associator, MergeNeighbours merge) : associator_(associator), merge_(merge) {}

void ChainJoiner::join_top_two(std::vector<ChainedMap>& stack, MergeNeighbours merge, MapAssociator& associator, JoinReport& report) {
  const ChainedMap top = std::move(stack.back());
  stack.pop_back();
  stack.back() = join_neighbours(stack.back(), top, merge, associator, report);
}

JoinReport ChainJoiner::take(const Submap& submap) {
  JoinReport report;
  stack_.push_back(chained_map_of(submap));
  while (stack_.size() > 1 && joins(stack_[stack_.size() - 2], stack_.back())) join_top_two(stack_, merge_, associator_, report);
  return report;
}

JoinReport ChainJoiner::finish() {
  JoinReport report;
  while (stack_.size() > 1) join_top_two(stack_, merge_, associator_, report);
  if (!stack_.empty()) associate_with_itself(stack_.front(), associator_, report);
  return report;
}

GaussianSe2 ChainJoiner::global_T_newest_base() const {
  GaussianSe2 global_T_base;
  for (const ChainedMap& chained : stack_) {  // (L-2): the maps are independent
    global_T_base =
        compose_independent(global_T_base, {chained.map.base_T_pose(0), chained.map.covariance(LiveMap::pose(0), LiveMap::pose(0))});
  }
  return global_T_base;
}

WorldEstimate ChainJoiner::estimate(BaseCovariance /*covariance*/) const {
  WorldEstimate estimate;
  estimate.global_T_base.emplace_back();
  if (stack_.empty()) return estimate;
  std::vector<ChainedMap> joined;
  if (stack_.size() > 1) {
    joined = stack_;
    MapAssociator associator = associator_;
    JoinReport unused;
    while (joined.size() > 1) join_top_two(joined, merge_, associator, unused);
  }
  const ChainedMap& chained = joined.empty() ? stack_.front() : joined.front();
  const LiveMap& map = chained.map;  // in the frame of base 0
  estimate.global_T_base.clear();
  for (const BorderEstimate& border : chained.borders) {
    estimate.global_T_base.push_back(border.start);
    estimate.border_covariance.push_back(border.covariance);
  }
  estimate.global_T_base.push_back(chained.borders.back().end);
  for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
    const auto rows = map.landmark(i);
    estimate.landmarks.push_back({{map.mean(rows), map.covariance(rows, rows)}, map.landmarks[static_cast<std::size_t>(i)], map.base});
  }
  estimate.maps.push_back({map.base, map.members, static_cast<int>(map.landmark_count())});
  return estimate;
}

}  // namespace ssjs
