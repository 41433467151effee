#include "ssjs/survey/bottom_tracking.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/survey/side_scan_geometry.hpp"
#include "ssjs/survey/waterfall.hpp"

namespace ssjs {
namespace {

/// Both sides of a ping, mean amplitude by range bin; empty where it has no samples.
std::vector<double> profile_of(const SideScanPing& ping, const BottomTrackingConfig& config, std::size_t bins) {
  std::vector<double> sum(bins, 0.0);
  std::vector<int> count(bins, 0);
  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    const SideScanChannel* channel = channel_of(ping, side, config.channel_pair);
    if (!channel) continue;
    for (std::size_t i = 0; i < channel->samples.size(); ++i) {
      const double bin = std::floor(slant_range_m(ping, *channel, static_cast<double>(i)) / config.bin_m);
      if (!(bin >= 0) || !(bin < static_cast<double>(bins)) || !std::isfinite(channel->samples[i])) continue;
      sum[static_cast<std::size_t>(bin)] += channel->samples[i];
      ++count[static_cast<std::size_t>(bin)];
    }
  }
  if (std::all_of(count.begin(), count.end(), [](int n) { return n == 0; })) return {};
  double level = 0;
  for (std::size_t b = 0; b < bins; ++b) {  // a bin finer than the samples takes what is before it
    if (count[b] > 0) level = sum[b] / count[b];
    sum[b] = level;
  }
  return sum;
}

/// (SS-14) By bin: logarithm of the mean echo behind it over that of the mean before it.
std::vector<double> rise(const std::vector<double>& profile, std::size_t least, std::size_t window) {
  std::vector<double> sums(profile.size() + 1, 0.0);
  for (std::size_t b = 0; b < profile.size(); ++b) sums[b + 1] = sums[b] + profile[b];
  const double floor = 1e-3 * sums.back() / static_cast<double>(profile.size()) + std::numeric_limits<double>::min();
  std::vector<double> rises(profile.size(), -std::numeric_limits<double>::infinity());
  for (std::size_t b = least + 1; b + window <= profile.size(); ++b) {
    const double before = (sums[b] - sums[least]) / static_cast<double>(b - least);
    const double behind = (sums[b + window] - sums[b]) / static_cast<double>(window);
    rises[b] = std::log((behind + floor) / (before + floor));
  }
  return rises;
}

double farthest_m(const std::vector<SideScanPing>& pings, const BottomTrackingConfig& config) {
  double farthest = 0;
  for (const SideScanPing& ping : pings) {
    for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
      const SideScanChannel* channel = channel_of(ping, side, config.channel_pair);
      if (channel && !channel->samples.empty())
        farthest = std::max(farthest, slant_range_m(ping, *channel, static_cast<double>(channel->samples.size()) - 0.5));
    }
  }
  if (!(farthest > 0)) throw InvalidArgument("pings", static_cast<double>(pings.size()), "hold no samples to find the bottom in");
  return farthest;
}

}  // namespace

std::vector<double> track_bottom(const std::vector<SideScanPing>& pings, const BottomTrackingConfig& config) {
  throw_if_any(violations(config));
  const double range_m = farthest_m(pings, config);
  const double most_m = config.most_altitude_m > 0 ? std::min(config.most_altitude_m, range_m) : 0.75 * range_m;
  const auto window = static_cast<std::size_t>(std::max(1.0, std::round(config.window_m / config.bin_m)));
  const auto least = static_cast<std::size_t>(std::ceil(config.least_altitude_m / config.bin_m));
  const auto bins = static_cast<std::size_t>(std::ceil(most_m / config.bin_m)) + window;
  if (least + window + 1 >= bins) throw InvalidArgument("least_altitude_m", config.least_altitude_m, "leaves no range for the bottom");
  const auto step = static_cast<std::ptrdiff_t>(std::max(1.0, std::round(config.most_step_m / config.bin_m)));

  // (SS-15) best sum of rises less costs of the steps, over all paths that end in a bin
  std::vector<double> best(bins, 0.0);
  std::vector<double> next(bins);
  std::vector<std::vector<std::int16_t>> came_from(pings.size(), std::vector<std::int16_t>(bins, 0));
  for (std::size_t n = 0; n < pings.size(); ++n) {
    const std::vector<double> profile = profile_of(pings[n], config, bins);
    const std::vector<double> rises = profile.empty() ? std::vector<double>(bins, 0.0) : rise(profile, least, window);
    for (std::ptrdiff_t b = 0; b < static_cast<std::ptrdiff_t>(bins); ++b) {
      double top = -std::numeric_limits<double>::infinity();
      std::ptrdiff_t from = 0;
      if (n == 0) top = 0;
      for (std::ptrdiff_t d = -step; n > 0 && d <= step; ++d) {
        if (b + d < 0 || b + d >= static_cast<std::ptrdiff_t>(bins)) continue;
        const double value = best[static_cast<std::size_t>(b + d)] - config.step_cost * static_cast<double>(std::abs(d));
        if (value > top || (value == top && std::abs(d) < std::abs(from))) {
          top = value;
          from = d;
        }
      }
      next[static_cast<std::size_t>(b)] = top + rises[static_cast<std::size_t>(b)];
      came_from[n][static_cast<std::size_t>(b)] = static_cast<std::int16_t>(from);
    }
    best.swap(next);
  }
  auto bin = std::max_element(best.begin(), best.end()) - best.begin();
  std::vector<double> first_returns_m(pings.size());
  for (std::size_t n = pings.size(); n-- > 0;) {
    first_returns_m[n] = static_cast<double>(bin) * config.bin_m;  // (SS-16) the edge before the first bin with echo
    bin += came_from[n][static_cast<std::size_t>(bin)];
  }
  return first_returns_m;
}

}  // namespace ssjs
