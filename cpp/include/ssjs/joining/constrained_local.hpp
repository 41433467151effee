/// The constrained local submap filter (CLSF): the global map keeps the frame of the present local map as a state; a finished local map
/// is moved into the global frame and its matched landmarks are constrained to equal those there already. [williams2002],
/// docs/math/joining_methods.md (K-1..K-3).
#pragma once

#include "ssjs/joining/chain_joiner.hpp"

namespace ssjs {

/// The contract of fuse() for neighbours (a holds the base of b as a pose, and the exit of b is the only pose it has): one linear
/// projection, no relinearisation. chi_squared has 2 degrees of freedom a pair.
[[nodiscard]] Fusion project(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs);

class ConstrainedLocalJoiner final : public ChainJoiner {
 public:
  explicit ConstrainedLocalJoiner(MapAssociator associator) : ChainJoiner(associator, &project) {}

 private:
  [[nodiscard]] bool joins(const ChainedMap& /*below*/, const ChainedMap& /*top*/) const override { return true; }
};

}  // namespace ssjs
