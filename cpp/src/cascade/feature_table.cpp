#include "ssjs/cascade/feature_table.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/parallel_blocks.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kFeaturesPerBlock = 512;
constexpr std::size_t kLanes = 16;

using Corners = std::array<const std::uint32_t*, 4>;

float weighted(const Corners& c, std::size_t i, float weight) {
  return weight * static_cast<float>(static_cast<std::int32_t>(c[0][i] - c[1][i] - c[2][i] + c[3][i]));
}

/// Least and greatest of `count` >= 1 values, in lanes for the compiler to run side by side.
std::pair<float, float> extent(const float* values, std::size_t count) {
  std::array<float, kLanes> lowest;
  std::array<float, kLanes> highest;
  lowest.fill(values[0]);
  highest.fill(values[0]);
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      lowest[k] = values[i + k] < lowest[k] ? values[i + k] : lowest[k];
      highest[k] = values[i + k] > highest[k] ? values[i + k] : highest[k];
    }
  for (; i < count; ++i) {
    lowest[0] = std::min(lowest[0], values[i]);
    highest[0] = std::max(highest[0], values[i]);
  }
  return {*std::min_element(lowest.begin(), lowest.end()), *std::max_element(highest.begin(), highest.end())};
}

}  // namespace

FeatureTable::FeatureTable(const std::vector<HaarFeature>& features, const WindowSet& positives, const WindowSet& negatives,
                           std::size_t memory_bytes, int threads)
    : features_(features), window_(positives.window()) {
  if (negatives.window() != window_) throw InvalidArgument("negatives", "another window size", "must be as large as the positives");
  for (const HaarFeature& feature : features) check_feature(feature, window_);
  has_diagonal_ = std::any_of(features.begin(), features.end(), [](const HaarFeature& feature) { return feature.tilted; });
  WindowSet usable(window_);
  const auto keep_usable = [&](const WindowSet& windows) {
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const auto norm = normalisation(IntegralImage(windows[i]), {0, 0}, window_);
      if (!norm) continue;
      usable.add(windows[i]);
      norms_.push_back(*norm);
    }
  };
  keep_usable(positives);
  positives_ = usable.size();
  keep_usable(negatives);
  take_in(usable);

  kept_rows_ = samples() == 0 ? 0 : std::min(features.size(), memory_bytes / samples());
  kept_.resize(kept_rows_ * samples());
  parallel_blocks((kept_rows_ + kFeaturesPerBlock - 1) / kFeaturesPerBlock, threads, [&](std::size_t block) {
    std::vector<float> row(samples());
    const std::size_t end = std::min(kept_rows_, (block + 1) * kFeaturesPerBlock);
    for (std::size_t f = block * kFeaturesPerBlock; f < end; ++f) form_bins(f, row, kept_.data() + f * samples());
  });
}

void FeatureTable::take_in(const WindowSet& windows) {
  const std::size_t corner_count = static_cast<std::size_t>((window_.width + 1) * (window_.height + 1));
  sums_.resize(corner_count * samples());
  if (has_diagonal_) diagonals_.resize(corner_count * samples());
  for (std::size_t i = 0; i < samples(); ++i) {
    const IntegralImage integral(windows[i], has_diagonal_ ? IntegralImage::Diagonal::kWith : IntegralImage::Diagonal::kWithout);
    for (std::size_t corner = 0; corner < corner_count; ++corner) {
      sums_[corner * samples() + i] = integral.sum()[corner];
      if (has_diagonal_) diagonals_[corner * samples() + i] = integral.diagonal()[corner];
    }
  }
}

void FeatureTable::values(std::size_t index, float* values) const {
  const HaarFeature& feature = features_[index];
  const std::vector<std::uint32_t>& sums = feature.tilted ? diagonals_ : sums_;
  const auto corner_rows = [&](const WeightedRect& part) {
    Corners rows{};
    const auto points = corners(part.rect, feature.tilted);
    for (std::size_t k = 0; k < rows.size(); ++k)
      rows[k] = sums.data() + static_cast<std::size_t>(points[k].y * (window_.width + 1) + points[k].x) * samples();
    return rows;
  };
  const std::size_t count = samples();
  const float* norms = norms_.data();
  const Corners first = corner_rows(feature.rects[0]);
  const Corners second = corner_rows(feature.rects[1]);
  const float w0 = feature.rects[0].weight;
  const float w1 = feature.rects[1].weight;
  const float w2 = feature.rects[2].weight;
  if (w2 == 0) {
    for (std::size_t i = 0; i < count; ++i) values[i] = (weighted(first, i, w0) + weighted(second, i, w1)) * norms[i];
  } else {
    const Corners third = corner_rows(feature.rects[2]);
    for (std::size_t i = 0; i < count; ++i)
      values[i] = ((weighted(first, i, w0) + weighted(second, i, w1)) + weighted(third, i, w2)) * norms[i];
  }
}

void FeatureTable::form_bins(std::size_t index, std::vector<float>& row, Bin* bins) const {
  values(index, row.data());
  const std::size_t count = row.size();
  const float* value = row.data();
  const auto [lowest, highest] = extent(value, count);
  // Every step below keeps order, so that bins are intervals of values whatever is rounded.
  const float per_value = highest > lowest ? static_cast<float>(kBins) * 0.9999F / (highest - lowest) : 0.0F;
  constexpr int kLast = static_cast<int>(kBins) - 1;
  std::array<Bin, kLanes> packed;  // apart from `bins`, which could be taken for anything in memory
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k)
      packed[k] = static_cast<Bin>(std::min(kLast, static_cast<int>((value[i + k] - lowest) * per_value)));
    std::memcpy(bins + i, packed.data(), kLanes);
  }
  for (; i < count; ++i) bins[i] = static_cast<Bin>(std::min(kLast, static_cast<int>((value[i] - lowest) * per_value)));
}

const FeatureTable::Bin* FeatureTable::bins(std::size_t index, Scratch& scratch) const {
  if (index < kept_rows_) return kept_.data() + index * samples();
  scratch.values.resize(samples());
  scratch.bins.resize(samples());
  form_bins(index, scratch.values, scratch.bins.data());
  return scratch.bins.data();
}

}  // namespace ssjs
