/// Fuses two live maps on matched landmarks and shared base frames, without any prior on their relative pose.
/// Thesis 3.3.3 corrected; docs/math/ssjs.md (J-8..J-12).
#pragma once

#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/joining/live_map.hpp"

namespace ssjs {

struct Fusion {
  LiveMap map;  ///< in a's frame, every pose kept, none declared a port yet (ports = 0, no conditional form)
  double chi_squared = 0.0;
  int dof = 0;  ///< constraints - 3; chi_squared tests the pairing when dof > 0
};

/// pairs: observation = landmark of b, prediction = landmark of a. Needs two pairs at different places, or a shared base frame;
/// otherwise throws NotPositiveDefinite ("relative pose"). a and b stay untouched; both must be independent.
[[nodiscard]] Fusion fuse(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs);

}  // namespace ssjs
