/// Windows on their way through a growing cascade: which of them stand, and what the stage in the making says about each.
/// docs/math/cascade.md (C-17).
#pragma once

#include <cstddef>
#include <vector>

#include "ssjs/cascade/haar_cascade.hpp"
#include "ssjs/cascade/window_set.hpp"
#include "ssjs/cascade/window_sums.hpp"

namespace ssjs {

/// A stump in the place where training put it, and moved by 1, 2, ... steps towards accepting.
struct MovableStump {
  HaarFeature feature;
  std::vector<float> thresholds;  ///< by move
  float left = 0;
  float right = 0;
};

/// Sums of a growing stage over some windows, for each of the moves.
class StageSums {
 public:
  StageSums(std::size_t windows, std::size_t moves) : sums_(moves, std::vector<double>(windows, 0.0)) {}
  /// `values`: of the stump's feature, one a window.
  void add(const MovableStump& stump, const std::vector<float>& values);
  [[nodiscard]] const std::vector<double>& of_move(std::size_t move) const { return sums_[move]; }

 private:
  std::vector<std::vector<double>> sums_;
};

/// The windows of a set, and which of them have passed all layers so far.
class FollowedWindows {
 public:
  FollowedWindows(const WindowSet& windows, WindowSums::Diagonal diagonal);

  void begin_layer(std::size_t moves) { sums_ = StageSums(standing_.size(), moves); }
  void add(const MovableStump& stump);
  /// A finished layer.
  void pass(const CascadeStage& stage, const std::vector<HaarFeature>& features);

  /// Share of all windows that have passed the finished layers.
  [[nodiscard]] double rate() const;
  /// Share of all windows that stand after a layer with this pass mark.
  [[nodiscard]] double rate_at(float mark, std::size_t move) const;
  /// (C-17): the highest threshold that leaves at least `rate` of all windows standing, or all that still do.
  [[nodiscard]] float threshold_for(double rate, std::size_t move) const;
  /// Their indices in the set.
  [[nodiscard]] std::vector<std::size_t> standing() const;

 private:
  WindowSums windows_;
  std::vector<bool> standing_;
  StageSums sums_;
  std::vector<float> values_;
};

}  // namespace ssjs
