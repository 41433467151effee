/// Divide and conquer (D&C SLAM): maps of equal weight are joined, as a binary counter carries. [paz2008],
/// docs/math/joining_methods.md (D-1).
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/chain_joiner.hpp"

namespace ssjs {

struct DivideAndConquerConfig {
  int rjc_above_landmarks = 60;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("rjc_above_landmarks", rjc_above_landmarks, Rule::at_least(3),
            "divide and conquer: joint compatibility gives way to its randomised form where more landmarks of one of two maps can meet "
            "those of the other");
  }
};

class DivideAndConquerJoiner final : public ChainJoiner {
 public:
  /// association: with randomized_above set from the configuration.
  explicit DivideAndConquerJoiner(MapAssociator associator) : ChainJoiner(associator, &fuse) {}

 private:
  [[nodiscard]] bool joins(const ChainedMap& below, const ChainedMap& top) const override {
    return below.map.members.size() == top.map.members.size();  // (D-1)
  }
};

}  // namespace ssjs
