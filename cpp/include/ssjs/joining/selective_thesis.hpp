/// Selective submap joining as the thesis prints it (3.3.2 to 3.3.4): the newer map is referred to the older one by the chain of links, the
/// two are fused, and the fused link goes back to the chain as an observation. It counts the chain again at every fusion: kept to show by
/// how much. docs/math/joining_methods.md (T-1..T-3), docs/math/ssjs.md.
#pragma once

#include "ssjs/joining/relative_joiner.hpp"

namespace ssjs {

class SelectiveThesisJoiner final : public RelativeJoiner {
 public:
  SelectiveThesisJoiner(const SelectiveJoinerConfig& config, AssociationMethod association, std::optional<int> max_submap_landmarks,
                        std::uint64_t seed)
      : RelativeJoiner(config, association, max_submap_landmarks, seed) {}

 private:
  void close_loops(const NewMap& fresh, JoinReport& report) override;
  /// Merges the map at base `b` into the one at base `a` < b; false when they do not fit.
  bool merge(int a, int b, const std::vector<Pair>& pairs, LoopAttempt& attempt);
};

}  // namespace ssjs
