/// A layer of stumps all of which a window has to pass. docs/math/cascade.md (C-21).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ssjs/cascade/feature_table.hpp"
#include "ssjs/cascade/stump_search.hpp"

namespace ssjs {

/// Chosen so that together they lose no more than a part of the objects and let as few as possible of the other windows pass. The result
/// does not depend on `threads`.
class RejectingStumps {
 public:
  /// `lost`: the part of the table's objects that `count` stumps may lose, in [0, 1]. `table` is referred to.
  RejectingStumps(const FeatureTable& table, double lost, int count, int threads);

  [[nodiscard]] const std::vector<Stump>& stumps() const { return stumps_; }

  /// One more; k of them may lose k parts in `count` of what all may. None if none rejects anything.
  std::optional<Stump> next();

  /// Each in turn is looked for anew beside the others, with all the objects that they leave it to lose, until nothing gets better.
  void refine();

 private:
  [[nodiscard]] std::vector<unsigned char> standing_without(std::size_t stump) const;
  [[nodiscard]] std::size_t negatives_left() const;
  [[nodiscard]] std::optional<Stump> best_in_place(std::size_t stump, std::size_t lost) const;
  [[nodiscard]] std::vector<unsigned char> passed_by(const Stump& stump) const;

  const FeatureTable& table_;
  double lost_;  ///< objects
  int count_;
  int threads_;
  std::vector<Stump> stumps_;
  std::vector<std::vector<unsigned char>> passed_;  ///< by stump, by sample
};

}  // namespace ssjs
