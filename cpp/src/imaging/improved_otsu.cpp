#include "ssjs/imaging/improved_otsu.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ssjs/imaging/contours.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/threshold.hpp"

namespace ssjs {
namespace {

/// Where a threshold lies on the scale that the contours are drawn on: the full one of 8 bits, the valid range of 16 bits.
double fraction_of_scale(int threshold, const SonarImage& image, const Histogram& levels) {
  if (image.intensity.depth() == CV_8U) return threshold / 255.0;
  const auto [lowest, highest] = *occupied_levels(levels);
  return static_cast<double>(threshold - lowest) / (highest - lowest);
}

}  // namespace

std::optional<ImprovedOtsu> improved_otsu(const SonarImage& image, const ImprovedOtsuConfig& config) {
  throw_if_any(violations(config));
  const Histogram levels = histogram(image);
  const std::optional<int> T = otsu_threshold(levels);
  if (!T) return std::nullopt;

  const std::int64_t valid_px = std::accumulate(levels.counts.begin(), levels.counts.end(), std::int64_t{0});
  ImprovedOtsu result;
  result.first_threshold = result.threshold = *T;
  result.spot_px = config.spot_px.value_or(automatic_spot_px(valid_px));
  result.spot_limit = config.spot_limit ? *config.spot_limit : automatic_spot_limit(valid_px, result.spot_px);
  result.canny_high = config.canny_high.value_or(fraction_of_scale(*T, image, levels));        // (O-8)
  result.spots = count_small_contours(canny_edges(image, result.canny_high), result.spot_px);  // (O-9)

  result.second_pass_fired = static_cast<double>(result.spots) > result.spot_limit;
  if (result.second_pass_fired) result.threshold = otsu_threshold(levels, *T + 1).value_or(*T);  // (O-10), the paper's 1 to 10
  return result;
}

int automatic_spot_px(std::int64_t valid_px) {
  return static_cast<int>(std::clamp(std::round(0.0375 * std::sqrt(static_cast<double>(valid_px))), 10.0, 60.0));
}

double automatic_spot_limit(std::int64_t valid_px, int spot_px) { return static_cast<double>(valid_px) / (70.0 * spot_px); }

}  // namespace ssjs
