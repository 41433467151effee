/// Hierarchical SLAM (HS): independent local maps below, a relative stochastic map of their links above. A loop is a constraint on the
/// links; maps are never merged. [estrada2005], docs/math/joining_methods.md (H-1..H-4).
#pragma once

#include "ssjs/joining/relative_joiner.hpp"

namespace ssjs {

class HierarchicalJoiner final : public RelativeJoiner {
 public:
  HierarchicalJoiner(const SelectiveJoinerConfig& config, AssociationMethod association, std::optional<int> max_submap_landmarks,
                     std::uint64_t seed)
      : RelativeJoiner(config, association, max_submap_landmarks, seed) {}

 private:
  void close_loops(const NewMap& fresh, JoinReport& report) override;
};

}  // namespace ssjs
