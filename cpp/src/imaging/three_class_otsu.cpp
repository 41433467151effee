#include "ssjs/imaging/three_class_otsu.hpp"

#include <array>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

std::optional<ThreeClasses> three_class_otsu(const Histogram& histogram) {
  constexpr int kLevels = 256;
  const int levels = histogram.levels();
  if (levels > kLevels) throw InvalidArgument("histogram", levels, "must have at most 256 levels");
  // Pixels and sum of levels below each level.
  std::array<double, kLevels + 1> pixels{};
  std::array<double, kLevels + 1> sum{};
  for (int level = 0; level < levels; ++level) {
    const auto i = static_cast<std::size_t>(level);
    const auto count = static_cast<double>(histogram[level]);
    pixels[i + 1] = pixels[i] + count;
    sum[i + 1] = sum[i] + count * level;
  }
  // With the mean of all fixed, the variance between classes grows with the sum over them of (sum of levels)^2 / pixels.
  const auto share = [&](int from, int to) {  // levels from .. to - 1
    const double n = pixels[static_cast<std::size_t>(to)] - pixels[static_cast<std::size_t>(from)];
    const double s = sum[static_cast<std::size_t>(to)] - sum[static_cast<std::size_t>(from)];
    return n > 0 ? std::optional<double>(s * s / n) : std::nullopt;
  };
  std::optional<ThreeClasses> best;
  double best_spread = 0;
  for (int lower = 0; lower < levels; ++lower) {
    const std::optional<double> dark = share(0, lower + 1);
    if (!dark) continue;
    for (int upper = lower + 1; upper < levels; ++upper) {
      const std::optional<double> middle = share(lower + 1, upper + 1);
      const std::optional<double> bright = share(upper + 1, levels);
      if (!middle || !bright) continue;
      const double spread = *dark + *middle + *bright;
      if (best && spread <= best_spread) continue;
      best = ThreeClasses{lower, upper};
      best_spread = spread;
    }
  }
  return best;
}

}  // namespace ssjs
