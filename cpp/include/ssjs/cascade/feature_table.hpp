/// The values of all features on all training windows, binned once per stage. docs/math/cascade.md (C-7).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ssjs/cascade/haar_feature.hpp"
#include "ssjs/cascade/window_sums.hpp"

namespace ssjs {

/// Positives first, negatives after them; windows too flat to be normalised, which no cascade passes, are left out.
/// Bin numbers of features that do not fit the memory allowed are formed anew whenever asked for: slower, with the same result.
class FeatureTable {
 public:
  static constexpr std::size_t kBins = 128;
  using Bin = std::uint8_t;

  FeatureTable(const std::vector<HaarFeature>& features, const WindowSet& positives, const WindowSet& negatives, std::size_t memory_bytes,
               int threads);

  [[nodiscard]] std::size_t features() const { return features_.size(); }
  [[nodiscard]] std::size_t positives() const { return positives_; }
  [[nodiscard]] std::size_t samples() const { return sums_.size(); }
  [[nodiscard]] const HaarFeature& feature(std::size_t index) const { return features_[index]; }

  /// Row `index` as the detector would compute it: samples() numbers.
  void values(std::size_t index, float* values) const { sums_.values(features_[index], values); }

  /// Its bins, equally wide between the row's least and greatest value: a greater value is never in a lower bin.
  /// `scratch` serves rows that are not kept, and must outlive the result's use.
  struct Scratch {
    std::vector<float> values;
    std::vector<Bin> bins;
  };
  [[nodiscard]] const Bin* bins(std::size_t index, Scratch& scratch) const;

  /// Whether the row's bins are at hand.
  [[nodiscard]] bool keeps(std::size_t index) const { return index < kept_rows_; }
  [[nodiscard]] bool keeps_all() const { return kept_rows_ == features_.size(); }
  /// Some of the samples, in that order, and the bins of row `index` for them alone: a look at a row that is not kept.
  [[nodiscard]] WindowSums select(const std::vector<std::uint32_t>& samples) const { return sums_.select(samples); }
  [[nodiscard]] const Bin* bins_of(const WindowSums& selected, std::size_t index, Scratch& scratch) const;

 private:
  /// Where the bins of a row begin, and how many of them there are to a unit.
  struct Binning {
    float lowest = 0;
    float per_value = 0;
  };
  [[nodiscard]] static Binning binning_of(const std::vector<float>& row);
  static void form_bins(const std::vector<float>& row, Binning binning, Bin* bins);

  const std::vector<HaarFeature>& features_;
  std::size_t positives_ = 0;
  WindowSums sums_;
  std::vector<Binning> binnings_;  ///< by feature
  std::vector<Bin> kept_;
  std::size_t kept_rows_ = 0;
};

}  // namespace ssjs
