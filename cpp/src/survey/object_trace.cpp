#include "ssjs/survey/object_trace.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ssjs {
namespace {

constexpr int kMarginRows = 3;

/// Ends of an object are lower than its middle.
cv::Range middle_half(const cv::Range& rows) { return {rows.start + rows.size() / 4, rows.end - rows.size() / 4}; }

/// The longest run of rows in which, averaged with their neighbours, a shadow begins; all of them where it does in none.
cv::Range rows_with_shadow(const SwathView& view, const cv::Range& rows, const cv::Range& echo, const TraceLevels& levels) {
  cv::Range longest(0, 0);
  cv::Range run(0, 0);
  for (int row = rows.start; row < rows.end; ++row) {
    const cv::Range three(std::max(row - 1, rows.start), std::min(row + 2, rows.end));
    const std::optional<ShadowEdges> shadow = shadow_behind(range_profile(view, three), echo, levels.gap, levels.shadow);
    if (!shadow || shadow->end - shadow->start < levels.least_shadow) continue;
    run = run.end == row ? cv::Range(run.start, row + 1) : cv::Range(row, row + 1);
    if (run.size() > longest.size()) longest = run;
  }
  return longest.empty() ? rows : longest;
}

double mean_between(const RangeProfile& profile, double from, double to) {
  const int low = std::clamp(static_cast<int>(std::lround(from)), 0, profile.columns() - 1);
  const int high = std::clamp(static_cast<int>(std::lround(to)), low + 1, profile.columns());
  double sum = 0;
  for (int k = low; k < high; ++k) sum += profile[k];
  return sum / (high - low);
}

/// (SS-33) From the middle of the rows to both sides, or a few rows beyond them.
RowExtent along_extent(const SwathView& view, const cv::Range& rows, double near, const ShadowEdges& shadow, double seabed_level) {
  const int first = std::max(rows.start - kMarginRows, 0);
  const int end = std::min(rows.end + kMarginRows, view.rows());
  struct StandsOut {
    double echo;
    double shadow;
  };
  std::vector<StandsOut> by_row;
  StandsOut inside{0, 0};
  const cv::Range half = middle_half(rows);
  for (int row = first; row < end; ++row) {
    const RangeProfile profile = range_profile(view, {row, row + 1});
    by_row.push_back(
        {mean_between(profile, near, shadow.start) - seabed_level, seabed_level - mean_between(profile, shadow.start, shadow.end)});
    if (row < half.start || row >= half.end) continue;
    inside.echo += by_row.back().echo / half.size();
    inside.shadow += by_row.back().shadow / half.size();
  }
  const auto part = [&](int row) {
    const StandsOut& here = by_row[static_cast<std::size_t>(row - first)];
    const double echo = inside.echo > 0 ? std::clamp(here.echo / inside.echo, 0.0, 1.0) : 0.0;
    const double dark = inside.shadow > 0 ? std::clamp(here.shadow / inside.shadow, 0.0, 1.0) : 0.0;
    return 0.5 * (echo + dark);
  };
  const auto half_way = [&](int outside, int within) {  // between the middles of two neighbouring rows
    return std::clamp((0.5 - part(outside)) / (part(within) - part(outside)), 0.0, 1.0);
  };
  int low = rows.start + (rows.size() - 1) / 2;
  int high = low;
  while (low > first && part(low - 1) >= 0.5) --low;
  while (high + 1 < end && part(high + 1) >= 0.5) ++high;
  RowExtent extent{static_cast<double>(low), high + 1.0};
  if (low > first && part(low) > 0.5) extent.first = low - 0.5 + half_way(low - 1, low);
  if (high + 1 < end && part(high) > 0.5) extent.end = high + 1.5 - half_way(high + 1, high);
  return extent;
}

/// (SS-19) how far echo and shadow stand out of the seabed
double confidence_of(const RangeProfile& profile, const cv::Range& echo, const ShadowEdges& shadow, double seabed_level) {
  const double bright = profile[profile.brightest(echo)];
  const double highlight_part = bright > 0 ? std::max(0.0, 1.0 - seabed_level / bright) : 0.0;
  const double shadow_part = std::max(0.0, 1.0 - shadow.mean_grey / seabed_level);
  return std::sqrt(highlight_part * shadow_part);
}

std::optional<ObjectTrace> trace_rows(const SwathView& upright, const cv::Range& rows, const cv::Range& echo, const TraceLevels& levels) {
  ObjectTrace trace;
  trace.middle_row = 0.5 * (rows.start + rows.end - 1);
  trace.skew = skew_of(upright, rows, echo, 2.0 * levels.seabed);
  const SwathView view = upright.along(trace.middle_row, trace.skew);
  const RangeProfile profile = range_profile(view, middle_half(rows));
  const std::optional<ShadowEdges> shadow = shadow_behind(profile, echo, levels.gap, levels.shadow);
  if (!shadow || shadow->end - shadow->start < levels.least_shadow) return std::nullopt;
  trace.shadow = *shadow;
  trace.near = near_edge(profile, echo, levels.gap, shadow->start, levels.seabed);
  trace.rows = along_extent(view, rows, trace.near, *shadow, levels.seabed);
  trace.confidence = confidence_of(profile, echo, *shadow, levels.seabed);
  return trace;
}

}  // namespace

std::optional<ObjectTrace> trace_object(const SwathView& upright, const cv::Range& rows, const cv::Range& echo, const TraceLevels& levels) {
  const std::optional<ObjectTrace> found = trace_rows(upright, rows_with_shadow(upright, rows, echo, levels), echo, levels);
  if (!found) return std::nullopt;
  // Once more in the rows that it stands out in, which may be more or fewer than those of the detector.
  const cv::Range own(static_cast<int>(std::lround(found->rows.first)), static_cast<int>(std::lround(found->rows.end)));
  const std::optional<ObjectTrace> again = own.empty() ? std::nullopt : trace_rows(upright, own, echo, levels);
  return again ? again : found;
}

}  // namespace ssjs
