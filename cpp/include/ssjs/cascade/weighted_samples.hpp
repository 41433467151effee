/// Training samples by weight, in whole units. docs/math/cascade.md (C-8), (C-11).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ssjs/cascade/stump_gain.hpp"

namespace ssjs {

class WeightedSamples {
 public:
  /// Weights: positives first, not negative. Throws InvalidArgument unless their sum is positive and finite.
  WeightedSamples(const std::vector<double>& weights, std::size_t positives);

  [[nodiscard]] bool is_positive(std::size_t sample) const { return sample < positives_; }
  [[nodiscard]] std::uint32_t units(std::size_t sample) const { return units_[sample]; }
  [[nodiscard]] Mass all() const { return counted_.empty() ? Mass{} : counted_.back(); }

  /// Those that weigh something. The heaviest of each class come first, the classes at equal shares of their mass: the sooner a part of
  /// the samples speaks for all.
  [[nodiscard]] const std::vector<std::uint32_t>& heaviest_first() const { return order_; }
  /// What the first `count` >= 1 of them weigh.
  [[nodiscard]] Mass of_first(std::size_t count) const { return counted_[count - 1]; }
  /// How many of them weigh more than `mass` together, or all.
  [[nodiscard]] std::size_t heavier_than(double mass) const;

 private:
  void order_samples();

  std::size_t positives_;
  std::vector<std::uint32_t> units_;
  std::vector<std::uint32_t> order_;
  std::vector<Mass> counted_;
};

}  // namespace ssjs
