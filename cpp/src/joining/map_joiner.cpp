#include "ssjs/joining/map_joiner.hpp"

namespace ssjs {

void JoinReport::append(const JoinReport& later) {
  candidates += later.candidates;
  loops.insert(loops.end(), later.loops.begin(), later.loops.end());
  neighbours.insert(neighbours.end(), later.neighbours.begin(), later.neighbours.end());
  fusions += later.fusions;
  association_time_s += later.association_time_s;
  budget_exhausted = budget_exhausted || later.budget_exhausted;
  fixes.insert(fixes.end(), later.fixes.begin(), later.fixes.end());
  unsound += later.unsound;
}

}  // namespace ssjs
