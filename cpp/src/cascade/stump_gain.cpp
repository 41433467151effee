#include "ssjs/cascade/stump_gain.hpp"

#include <algorithm>

namespace ssjs {
namespace {

constexpr std::size_t kBins = FeatureTable::kBins;
constexpr double kRoundingSlack = 1e-5;  // bounds are formed in single precision

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

/// (C-10): no split of the samples counted so far gains more, wherever in a bin it falls.
template <BoostType Type>
double gain_bound(const MassHistogram& histogram, Mass all) {
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
  return static_cast<double>(*std::max_element(greatest.begin(), greatest.end())) + kRoundingSlack * kWholeMass;
}

}  // namespace

double split_gain(BoostType type, Mass left, Mass all) {
  if (type == BoostType::kGentle) return gain<BoostType::kGentle, double>(left.positive, left.negative, all.positive, all.negative);
  return gain<BoostType::kDiscrete, double>(left.positive, left.negative, all.positive, all.negative);
}

double gain_bound(BoostType type, const MassHistogram& histogram, Mass all) {
  return type == BoostType::kGentle ? gain_bound<BoostType::kGentle>(histogram, all) : gain_bound<BoostType::kDiscrete>(histogram, all);
}

}  // namespace ssjs
