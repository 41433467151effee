#include "ssjs/cascade/stump_search.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/cascade/parallel_blocks.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kBins = FeatureTable::kBins;
constexpr double kUnits = 1U << 30U;  // what the weights of all samples add up to
constexpr std::size_t kFeaturesPerBlock = 256;
constexpr std::size_t kScoutStride = 61;  // features looked at first, for a good gain to measure the others by
constexpr double kRoundingSlack = 1e-5;   // bounds are formed in single precision
constexpr double kLeastSmoothing = 1e-6;  // an empty class on one side of a Discrete stump: error at least this

/// Weights of the positives and of the negatives, in units.
struct Mass {
  std::uint32_t positive = 0;
  std::uint32_t negative = 0;
};

/// (C-8): what a split gains when `left` of `all` goes left. Written with comparisons that the compiler turns into vector code.
template <BoostType Type, class Real>
Real gain(Real left_positive, Real left_negative, Real all_positive, Real all_negative) {
  const Real right_positive = all_positive - left_positive;
  const Real right_negative = all_negative - left_negative;
  if constexpr (Type == BoostType::kDiscrete) {
    const Real right_is_negative = left_positive + right_negative;
    const Real left_is_negative = left_negative + right_positive;
    return right_is_negative < left_is_negative ? left_is_negative : right_is_negative;
  } else {
    const Real left_mass = left_positive + left_negative;
    const Real right_mass = right_positive + right_negative;
    const Real left = left_mass < Real(1) ? Real(1) : left_mass;  // an empty side has no moment either
    const Real right = right_mass < Real(1) ? Real(1) : right_mass;
    const Real left_moment = left_positive - left_negative;
    const Real right_moment = right_positive - right_negative;
    return (left_moment * left_moment * right + right_moment * right_moment * left) / (left * right);  // one division for both sides
  }
}

double exact_gain(BoostType type, Mass left, Mass all) {
  if (type == BoostType::kGentle) return gain<BoostType::kGentle, double>(left.positive, left.negative, all.positive, all.negative);
  return gain<BoostType::kDiscrete, double>(left.positive, left.negative, all.positive, all.negative);
}

using Histogram = std::array<std::uint32_t, 2 * kBins>;  // negative and positive mass of each bin in turn

/// (C-10): no split of the samples counted so far gains more, wherever in a bin it falls.
template <BoostType Type>
double gain_bound(const Histogram& histogram, Mass all) {
  std::array<float, kBins + 1> positive_below;
  std::array<float, kBins + 1> negative_below;
  Mass below;
  for (std::size_t b = 0; b <= kBins; ++b) {
    positive_below[b] = static_cast<float>(static_cast<std::int32_t>(below.positive));
    negative_below[b] = static_cast<float>(static_cast<std::int32_t>(below.negative));
    if (b == kBins) break;
    below.negative += histogram[2 * b];
    below.positive += histogram[2 * b + 1];
  }
  const auto p = static_cast<float>(all.positive);
  const auto n = static_cast<float>(all.negative);
  std::array<float, kBins> bounds;
  for (std::size_t b = 0; b < kBins; ++b) {  // the upper edge, and the two corners that are no edges
    const float at_edge = gain<Type>(positive_below[b + 1], negative_below[b + 1], p, n);
    const float positives_first = gain<Type>(positive_below[b + 1], negative_below[b], p, n);
    const float negatives_first = gain<Type>(positive_below[b], negative_below[b + 1], p, n);
    const float of_corners = positives_first < negatives_first ? negatives_first : positives_first;
    bounds[b] = at_edge < of_corners ? of_corners : at_edge;
  }
  constexpr std::size_t kLanes = 16;
  std::array<float, kLanes> greatest;
  std::copy_n(bounds.begin(), kLanes, greatest.begin());
  for (std::size_t b = kLanes; b < kBins; b += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) greatest[k] = greatest[k] < bounds[b + k] ? bounds[b + k] : greatest[k];
  return static_cast<double>(*std::max_element(greatest.begin(), greatest.end())) + kRoundingSlack * kUnits;
}

double gain_bound(BoostType type, const Histogram& histogram, Mass all) {
  return type == BoostType::kGentle ? gain_bound<BoostType::kGentle>(histogram, all) : gain_bound<BoostType::kDiscrete>(histogram, all);
}

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
      : table_(table), type_(type), units_(table.samples()) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (!(sum > 0) || !std::isfinite(sum)) throw InvalidArgument("weights", sum, "must have a positive, finite sum");
    for (std::size_t i = 0; i < units_.size(); ++i) units_[i] = static_cast<std::uint32_t>(std::lround(weights[i] / sum * kUnits));
    order_samples();
    Mass counted;
    for (const std::uint32_t i : order_) {
      in_order_.push_back({i, is_positive(i) ? 1U : 0U, units_[i]});
      (is_positive(i) ? counted.positive : counted.negative) += units_[i];
      counted_.push_back(counted);
    }
    all_ = counted;
  }

  /// One feature against the best gain known so far, by any thread.
  void examine(std::size_t feature, FeatureTable::Scratch& scratch, Cut& best) {
    const FeatureTable::Bin* bins = table_.bins(feature, scratch);
    Histogram histogram{};
    std::size_t counted = 0;
    for (const std::size_t end : checkpoints()) {
      for (; counted < end; ++counted) {
        const Counted& next = in_order_[counted];
        histogram[2U * bins[next.sample] + next.is_positive] += next.units;
      }
      if (counted == 0) continue;
      // (C-11): what is not counted yet can at best all be put right
      const Mass so_far = counted_[counted - 1];
      const double uncounted = total(all_) - total(so_far);
      if (gain_bound(type_, histogram, so_far) + uncounted < best_gain_.load(std::memory_order_relaxed)) return;
    }
    refine(feature, bins, histogram, best);
  }

  [[nodiscard]] Stump stump_of(const Cut& split, const std::vector<double>& weights) const;

 private:
  /// The heaviest of each class first, the classes at equal shares of their mass: the sooner a part of the samples speaks for all.
  void order_samples() {
    std::array<std::vector<std::uint32_t>, 2> classes;
    std::array<double, 2> mass{};
    for (std::size_t i = 0; i < units_.size(); ++i) {
      if (units_[i] == 0) continue;
      const std::size_t c = is_positive(i) ? 1 : 0;
      classes[c].push_back(static_cast<std::uint32_t>(i));
      mass[c] += units_[i];
    }
    for (auto& samples : classes)
      std::stable_sort(samples.begin(), samples.end(), [&](std::uint32_t a, std::uint32_t b) { return units_[a] > units_[b]; });
    std::array<double, 2> taken{};
    std::array<std::size_t, 2> next{};
    while (order_.size() < classes[0].size() + classes[1].size()) {
      const bool first_lags = taken[0] * mass[1] <= taken[1] * mass[0];
      const std::size_t c = next[1] == classes[1].size() || (first_lags && next[0] < classes[0].size()) ? 0 : 1;
      order_.push_back(classes[c][next[c]++]);
      taken[c] += units_[order_.back()];
    }
  }

  [[nodiscard]] bool is_positive(std::size_t sample) const { return sample < table_.positives(); }
  static double total(Mass mass) { return static_cast<double>(mass.positive) + mass.negative; }

  /// How many samples, heaviest first, to count before asking whether the feature can still win. A feature that tells nothing
  /// gains nearly nothing; it is out once what is counted outweighs the best loss.
  [[nodiscard]] std::array<std::size_t, 3> checkpoints() const {
    const double least_loss = total(all_) - best_gain_.load(std::memory_order_relaxed);
    const auto heavier_than = [&](double mass) {
      const auto found = std::partition_point(counted_.begin(), counted_.end(), [&](Mass counted) { return total(counted) < mass; });
      return std::min(order_.size(), static_cast<std::size_t>(found - counted_.begin()) + 1);
    };
    return {heavier_than(1.25 * least_loss), heavier_than(1.8 * least_loss), order_.size()};
  }

  /// (C-9), (C-10): the gain at every edge, and inside those bins that could hold more than the best known.
  void refine(std::size_t feature, const FeatureTable::Bin* bins, const Histogram& histogram, Cut& best) {
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
        const double bound = std::max(exact_gain(type_, {left.positive + positive, left.negative}, all_),
                                      exact_gain(type_, {left.positive, left.negative + negative}, all_));
        if (bound >= best_gain_.load(std::memory_order_relaxed)) split_bin(feature, bins, b, left, offer);
      }
      left.positive += positive;
      left.negative += negative;
      const bool splits = total(left) > 0 && total(left) < total(all_) && positive + negative > 0;
      if (splits) offer({exact_gain(type_, left, all_), feature, b, true, 0});
    }
  }

  template <class Offer>
  void split_bin(std::size_t feature, const FeatureTable::Bin* bins, std::size_t bin, Mass left, const Offer& offer) {
    thread_local std::vector<float> values;
    thread_local std::vector<std::pair<float, std::uint32_t>> members;
    values.resize(table_.samples());
    table_.values(feature, values.data());
    members.clear();
    for (const std::uint32_t i : order_)
      if (bins[i] == bin) members.emplace_back(values[i], i);
    std::sort(members.begin(), members.end());
    for (std::size_t k = 0; k + 1 < members.size(); ++k) {
      const auto [value, sample] = members[k];
      (is_positive(sample) ? left.positive : left.negative) += units_[sample];
      if (value < members[k + 1].first) offer(Cut{exact_gain(type_, left, all_), feature, bin, false, value});
    }
  }

  struct Counted {
    std::uint32_t sample;
    std::uint32_t is_positive;
    std::uint32_t units;
  };

  const FeatureTable& table_;
  BoostType type_;
  std::vector<std::uint32_t> units_;
  std::vector<std::uint32_t> order_;  ///< samples, heaviest first
  std::vector<Counted> in_order_;     ///< the same, with what is counted of them
  std::vector<Mass> counted_;         ///< mass of the first 1, 2, ... of them
  Mass all_;
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
    if (units_[i] > 0 && left) last_left = std::max(last_left, values[i]);
    if (units_[i] > 0 && !left) first_right = std::min(first_right, values[i]);
    mass[left ? 0 : 1][is_positive(i) ? 1 : 0] += weights[i];
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
  Cut best;
  const auto pass = [&](const std::vector<std::uint32_t>& features) {
    const std::size_t blocks = (features.size() + kFeaturesPerBlock - 1) / kFeaturesPerBlock;
    std::vector<Cut> best_of_block(blocks);
    parallel_blocks(blocks, threads, [&](std::size_t block) {
      FeatureTable::Scratch scratch;
      const std::size_t end = std::min(features.size(), (block + 1) * kFeaturesPerBlock);
      for (std::size_t k = block * kFeaturesPerBlock; k < end; ++k) search.examine(features[k], scratch, best_of_block[block]);
    });
    for (const Cut& split : best_of_block)
      if (better(split, best)) best = split;
  };
  std::vector<std::uint32_t> scouts;
  std::vector<std::uint32_t> others;
  for (std::size_t f = 0; f < table.features(); ++f) (f % kScoutStride == 0 ? scouts : others).push_back(static_cast<std::uint32_t>(f));
  pass(scouts);
  pass(others);
  if (best.gain < 0) return std::nullopt;
  return search.stump_of(best, weights);
}

}  // namespace ssjs
