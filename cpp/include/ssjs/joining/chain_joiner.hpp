/// The methods that join neighbours: a stack of maps, each of which starts where the one below it ends. They differ in when the upper two
/// are joined and in how. docs/math/joining_methods.md.
#pragma once

#include <vector>

#include "ssjs/joining/chained_map.hpp"

namespace ssjs {

class ChainJoiner : public MapJoiner {
 public:
  [[nodiscard]] JoinReport take(const Submap& submap) final;
  /// The chain over the maps of the stack.
  [[nodiscard]] GaussianSe2 global_T_newest_base() const final;
  /// Joins what is left, from the top down, and associates the map with itself.
  JoinReport finish() final;
  /// Joins a copy of what is left on the stack, which costs as much as finish(). The joint covariance of all bases is not known to these
  /// methods.
  [[nodiscard]] WorldEstimate estimate(BaseCovariance covariance) const final;

  [[nodiscard]] const std::vector<ChainedMap>& stack() const { return stack_; }

 protected:
  ChainJoiner(MapAssociator associator, MergeNeighbours merge);

  /// Whether the two uppermost maps are joined now.
  [[nodiscard]] virtual bool joins(const ChainedMap& below, const ChainedMap& top) const = 0;

 private:
  static void join_top_two(std::vector<ChainedMap>& stack, MergeNeighbours merge, MapAssociator& associator, JoinReport& report);

  MapAssociator associator_;
  MergeNeighbours merge_;
  std::vector<ChainedMap> stack_;
};

}  // namespace ssjs
