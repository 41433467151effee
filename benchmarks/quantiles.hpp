/// Order statistics of measured times.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace ssjs::benchmarks {

/// The smallest value that at least the given fraction of the values does not exceed. 0 for none.
inline double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  const double rank = std::ceil(fraction * static_cast<double>(values.size()));
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::max(rank - 1.0, 0.0))];
}

inline double median(const std::vector<double>& values) { return quantile(values, 0.5); }
inline double largest(const std::vector<double>& values) { return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end()); }

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

}  // namespace ssjs::benchmarks
