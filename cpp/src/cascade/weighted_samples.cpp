#include "ssjs/cascade/weighted_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "ssjs/base/error.hpp"

namespace ssjs {

WeightedSamples::WeightedSamples(const std::vector<double>& weights, std::size_t positives)
    : positives_(positives), units_(weights.size()) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(sum > 0) || !std::isfinite(sum)) throw InvalidArgument("weights", sum, "must have a positive, finite sum");
  for (std::size_t i = 0; i < units_.size(); ++i) units_[i] = static_cast<std::uint32_t>(std::lround(weights[i] / sum * kWholeMass));
  order_samples();
  Mass counted;
  for (const std::uint32_t i : order_) {
    (is_positive(i) ? counted.positive : counted.negative) += units_[i];
    counted_.push_back(counted);
  }
}

void WeightedSamples::order_samples() {
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

std::size_t WeightedSamples::heavier_than(double mass) const {
  const auto found = std::partition_point(counted_.begin(), counted_.end(), [&](Mass counted) { return total(counted) < mass; });
  return std::min(order_.size(), static_cast<std::size_t>(found - counted_.begin()) + 1);
}

}  // namespace ssjs
