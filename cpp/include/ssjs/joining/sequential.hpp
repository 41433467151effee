/// Local map joining (LMJ): one growing map in the frame of base 0, to which every finished submap is joined. [tardos2002],
/// docs/math/joining_methods.md (L-1..L-5).
#pragma once

#include "ssjs/joining/chain_joiner.hpp"

namespace ssjs {

class SequentialJoiner final : public ChainJoiner {
 public:
  explicit SequentialJoiner(MapAssociator associator) : ChainJoiner(associator, &fuse) {}

 private:
  [[nodiscard]] bool joins(const ChainedMap& /*below*/, const ChainedMap& /*top*/) const override { return true; }
};

}  // namespace ssjs
