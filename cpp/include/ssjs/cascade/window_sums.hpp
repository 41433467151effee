/// The integral images of many windows, side by side: one feature on all of them at a time. docs/math/cascade.md (C-7).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ssjs/cascade/haar_feature.hpp"
#include "ssjs/cascade/window_set.hpp"

namespace ssjs {

class WindowSums {
 public:
  enum class Diagonal { kWithout, kWith };

  WindowSums(const WindowSet& windows, Diagonal diagonal);

  [[nodiscard]] std::size_t size() const { return norms_.size(); }
  /// Whether no cascade passes the window, since it has no normalisation.
  [[nodiscard]] bool is_flat(std::size_t window) const { return norms_[window] == 0; }

  /// Those windows, in that order.
  [[nodiscard]] WindowSums select(const std::vector<std::uint32_t>& windows) const;

  /// The feature on each window as the detector would compute it, size() numbers; 0 on flat ones.
  void values(const HaarFeature& feature, float* values) const;

 private:
  WindowSums() = default;

  int stride_ = 0;
  std::vector<float> norms_;
  std::vector<std::uint32_t> sums_;  ///< by corner, then by window: what is added alike lies side by side
  std::vector<std::uint32_t> diagonals_;
};

}  // namespace ssjs
