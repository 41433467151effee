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

bool any_tilted(const std::vector<HaarFeature>& features) {
  return std::any_of(features.begin(), features.end(), [](const HaarFeature& feature) { return feature.tilted; });
}

/// Those windows, in their order, that have a normalisation.
WindowSet usable(const WindowSet& windows) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < windows.size(); ++i)
    if (normalisation(IntegralImage(windows[i]), {0, 0}, windows.window())) chosen.push_back(i);
  return windows.select(chosen);
}

WindowSet together(WindowSet first, const WindowSet& second) {
  first.append(second);
  return first;
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
    : features_(features),
      positives_(usable(positives).size()),
      sums_(together(usable(positives), usable(negatives)),
            any_tilted(features) ? WindowSums::Diagonal::kWith : WindowSums::Diagonal::kWithout) {
  for (const HaarFeature& feature : features) check_feature(feature, positives.window());
  kept_rows_ = samples() == 0 ? 0 : std::min(features.size(), memory_bytes / samples());
  kept_.resize(kept_rows_ * samples());
  binnings_.resize(features.size());
  if (samples() == 0) return;
  parallel_blocks((features.size() + kFeaturesPerBlock - 1) / kFeaturesPerBlock, threads, [&](std::size_t block) {
    std::vector<float> row(samples());
    const std::size_t end = std::min(features.size(), (block + 1) * kFeaturesPerBlock);
    for (std::size_t f = block * kFeaturesPerBlock; f < end; ++f) {
      values(f, row.data());
      binnings_[f] = binning_of(row);
      if (keeps(f)) form_bins(row, binnings_[f], kept_.data() + f * samples());
    }
  });
}

FeatureTable::Binning FeatureTable::binning_of(const std::vector<float>& row) {
  const auto [lowest, highest] = extent(row.data(), row.size());
  return {lowest, highest > lowest ? static_cast<float>(kBins) * 0.9999F / (highest - lowest) : 0.0F};
}

void FeatureTable::form_bins(const std::vector<float>& row, Binning binning, Bin* bins) {
  const std::size_t count = row.size();
  const float* value = row.data();
  const auto [lowest, per_value] = binning;
  // Every step below keeps order, so that bins are intervals of values whatever is rounded.
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
  return keeps(index) ? kept_.data() + index * samples() : bins_of(sums_, index, scratch);
}

const FeatureTable::Bin* FeatureTable::bins_of(const WindowSums& selected, std::size_t index, Scratch& scratch) const {
  scratch.values.resize(selected.size());
  scratch.bins.resize(selected.size());
  selected.values(features_[index], scratch.values.data());
  form_bins(scratch.values, binnings_[index], scratch.bins.data());
  return scratch.bins.data();
}

}  // namespace ssjs
