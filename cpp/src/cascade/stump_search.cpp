#include "ssjs/cascade/stump_search.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/feature_sweep.hpp"
#include "ssjs/cascade/stump_gain.hpp"
#include "ssjs/cascade/weighted_samples.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kBins = FeatureTable::kBins;
constexpr double kLeastSmoothing = 1e-6;  // an empty class on one side of a Discrete stump: error at least this

/// A split of one feature: bins up to `bin` go left (at an edge), or the bins before it and its values up to `last_left`.
struct Cut {
  double gain = -1;
  std::size_t feature = std::numeric_limits<std::size_t>::max();
  std::size_t bin = 0;
  bool at_edge = true;
  float last_left = 0;
};

/// Whether `a` is to be preferred. Within a bin splits come before its upper edge.
bool better(const Cut& a, const Cut& b) {
  if (a.gain != b.gain) return a.gain > b.gain;
  return std::tuple(a.feature, a.bin, a.at_edge, a.last_left) < std::tuple(b.feature, b.bin, b.at_edge, b.last_left);
}

class Search {
 public:
  Search(const FeatureTable& table, const std::vector<double>& weights, BoostType type)
      : table_(table), type_(type), samples_(weights, table.positives()), all_(samples_.all()) {
    for (const std::uint32_t i : samples_.heaviest_first()) in_order_.push_back({i, samples_.is_positive(i) ? 1U : 0U, samples_.units(i)});
  }

  /// Rows that are not kept are from now on looked at on the heaviest samples before they are formed.
  void gather_heaviest() {
    const std::size_t count = checkpoints()[0];
    if (table_.keeps_all() || 2 * count > table_.samples()) return;
    const auto first = samples_.heaviest_first().begin();
    heaviest_ = table_.select({first, first + static_cast<std::ptrdiff_t>(count)});
  }

  /// One feature against the best gain known so far, by any thread.
  void examine(std::size_t feature, FeatureTable::Scratch& scratch, Cut& best) {
    if (heaviest_ && !table_.keeps(feature)) {
      const FeatureTable::Bin* bins = table_.bins_of(*heaviest_, feature, scratch);
      MassHistogram histogram{};
      const std::size_t count = heaviest_->size();
      for (std::size_t k = 0; k < count; ++k) histogram[2U * bins[k] + in_order_[k].is_positive] += in_order_[k].units;
      if (is_out(histogram, count)) return;
    }
    const FeatureTable::Bin* bins = table_.bins(feature, scratch);
    MassHistogram histogram{};
    std::size_t counted = 0;
    for (const std::size_t end : checkpoints()) {
      for (; counted < end; ++counted) {
        const Counted& next = in_order_[counted];
        histogram[2U * bins[next.sample] + next.is_positive] += next.units;
      }
      if (counted > 0 && is_out(histogram, counted)) return;
    }
    refine(feature, bins, histogram, best);
  }

  [[nodiscard]] Stump stump_of(const Cut& split, const std::vector<double>& weights) const;

 private:
  /// (C-11): what is not counted yet can at best all be put right.
  [[nodiscard]] bool is_out(const MassHistogram& histogram, std::size_t counted) const {
    const Mass so_far = samples_.of_first(counted);
    return gain_bound(type_, histogram, so_far) + total(all_) - total(so_far) < best_gain_.load(std::memory_order_relaxed);
  }

  /// How many samples, heaviest first, to count before asking whether the feature can still win. A feature that tells nothing
  /// gains nearly nothing; it is out once what is counted outweighs the best loss.
  [[nodiscard]] std::array<std::size_t, 3> checkpoints() const {
    const double least_loss = total(all_) - best_gain_.load(std::memory_order_relaxed);
    return {samples_.heavier_than(1.25 * least_loss), samples_.heavier_than(1.8 * least_loss), in_order_.size()};
  }

  /// (C-9), (C-10): the gain at every edge, and inside those bins that could hold more than the best known.
  void refine(std::size_t feature, const FeatureTable::Bin* bins, const MassHistogram& histogram, Cut& best) {
    const auto offer = [&](const Cut& split) {
      if (better(split, best)) best = split;
      double known = best_gain_.load(std::memory_order_relaxed);
      while (split.gain > known && !best_gain_.compare_exchange_weak(known, split.gain, std::memory_order_relaxed)) {
      }
    };
    Mass left;
    for (std::size_t b = 0; b < kBins; ++b) {
      const std::uint32_t negative = histogram[2 * b];
      const std::uint32_t positive = histogram[2 * b + 1];
      if (positive > 0 && negative > 0) {
        const double bound = std::max(split_gain(type_, {left.positive + positive, left.negative}, all_),
                                      split_gain(type_, {left.positive, left.negative + negative}, all_));
        if (bound >= best_gain_.load(std::memory_order_relaxed)) split_bin(feature, bins, b, left, offer);
      }
      left.positive += positive;
      left.negative += negative;
      const bool splits = total(left) > 0 && total(left) < total(all_) && positive + negative > 0;
      if (splits) offer({split_gain(type_, left, all_), feature, b, true, 0});
    }
  }

  template <class Offer>
  void split_bin(std::size_t feature, const FeatureTable::Bin* bins, std::size_t bin, Mass left, const Offer& offer) {
    thread_local std::vector<float> values;
    thread_local std::vector<std::pair<float, std::uint32_t>> members;
    values.resize(table_.samples());
    table_.values(feature, values.data());
    members.clear();
    for (const std::uint32_t i : samples_.heaviest_first())
      if (bins[i] == bin) members.emplace_back(values[i], i);
    std::sort(members.begin(), members.end());
    for (std::size_t k = 0; k + 1 < members.size(); ++k) {
      const auto [value, sample] = members[k];
      (samples_.is_positive(sample) ? left.positive : left.negative) += samples_.units(sample);
      if (value < members[k + 1].first) offer(Cut{split_gain(type_, left, all_), feature, bin, false, value});
    }
  }

  struct Counted {
    std::uint32_t sample;
    std::uint32_t is_positive;
    std::uint32_t units;
  };

  const FeatureTable& table_;
  BoostType type_;
  WeightedSamples samples_;
  Mass all_;
  std::vector<Counted> in_order_;       ///< samples, heaviest first, with what is counted of them
  std::optional<WindowSums> heaviest_;  ///< the first of them, for rows that are not kept
  std::atomic<double> best_gain_{-1.0};
};

/// Threshold midway between the values on its two sides; leaves from the weights themselves, summed in the order of the samples.
Stump Search::stump_of(const Cut& split, const std::vector<double>& weights) const {
  std::vector<float> values(table_.samples());
  table_.values(split.feature, values.data());
  FeatureTable::Scratch scratch;
  const FeatureTable::Bin* bins = table_.bins(split.feature, scratch);
  float last_left = -std::numeric_limits<float>::infinity();
  float first_right = std::numeric_limits<float>::infinity();
  std::array<std::array<double, 2>, 2> mass{};  // by side, by class
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool left = bins[i] < split.bin || (bins[i] == split.bin && (split.at_edge || values[i] <= split.last_left));
    if (samples_.units(i) > 0 && left) last_left = std::max(last_left, values[i]);
    if (samples_.units(i) > 0 && !left) first_right = std::min(first_right, values[i]);
    mass[left ? 0 : 1][samples_.is_positive(i) ? 1 : 0] += weights[i];
  }
  Stump stump{split.feature, last_left + (first_right - last_left) / 2, 0, 0};
  if (!(stump.threshold > last_left)) stump.threshold = first_right;
  if (type_ == BoostType::kGentle) {
    const auto mean = [](const std::array<double, 2>& side) { return static_cast<float>((side[1] - side[0]) / (side[0] + side[1])); };
    stump.left = mean(mass[0]);
    stump.right = mean(mass[1]);
    return stump;
  }
  const double all = mass[0][0] + mass[0][1] + mass[1][0] + mass[1][1];
  const double error_if_right_positive = (mass[0][1] + mass[1][0]) / all;
  const bool right_positive = error_if_right_positive <= 0.5;
  const double error = std::max(kLeastSmoothing, right_positive ? error_if_right_positive : 1 - error_if_right_positive);
  const auto vote = static_cast<float>(0.5 * std::log((1 - error) / error));
  stump.left = right_positive ? -vote : vote;
  stump.right = -stump.left;
  return stump;
}

}  // namespace

std::string to_string(BoostType type) { return type == BoostType::kGentle ? "gentle" : "discrete"; }

std::optional<Stump> best_stump(const FeatureTable& table, const std::vector<double>& weights, BoostType type, int threads) {
  if (weights.size() != table.samples())
    throw InvalidArgument("weights", static_cast<double>(weights.size()), "must be as many as samples: " + std::to_string(table.samples()));
  if (std::any_of(weights.begin(), weights.end(), [](double weight) { return !(weight >= 0); }))
    throw InvalidArgument("weights", "one below 0 or NaN", "must not be negative");
  Search search(table, weights, type);
  const Cut best = sweep_features<Cut>(
      table.features(), threads, [&](std::size_t f, FeatureTable::Scratch& scratch, Cut& found) { search.examine(f, scratch, found); },
      better, [&] { search.gather_heaviest(); });
  if (best.gain < 0) return std::nullopt;
  return search.stump_of(best, weights);
}

}  // namespace ssjs
