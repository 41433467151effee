#include "ssjs/survey/echo_profile.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr int kMarginRows = 3;
constexpr double kEchoOverSeabed = 1.6;  // between the seabed and the weakest echoes of objects, twice as strong

/// Where the profile passes the level between the middles of two neighbouring columns, as a part of their distance.
double crossing(double before, double behind, double level) {
  return before == behind ? 0.5 : std::clamp((level - before) / (behind - before), 0.0, 1.0);
}

/// Three columns: a speckle does not end a shadow.
double smooth(const RangeProfile& profile, int column) {
  const int low = std::max(column - 1, 0);
  const int high = std::min(column + 1, profile.columns() - 1);
  double sum = 0;
  for (int k = low; k <= high; ++k) sum += profile[k];
  return sum / (high - low + 1);
}

/// The middle half: ends of an object are lower than its middle.
cv::Range middle_half(const cv::Range& rows) { return {rows.start + rows.size() / 4, rows.end - rows.size() / 4}; }

double mean_between(const RangeProfile& profile, double from, double to) {
  const int low = std::clamp(static_cast<int>(std::lround(from)), 0, profile.columns() - 1);
  const int high = std::clamp(static_cast<int>(std::lround(to)), low + 1, profile.columns());
  double sum = 0;
  for (int k = low; k < high; ++k) sum += profile[k];
  return sum / (high - low);
}

}  // namespace

std::optional<double> SwathView::level(int row, int column) const {
  const int moved = column + static_cast<int>(std::lround(skew_ * (row - middle_row_)));
  if (moved < 0 || moved >= columns()) return std::nullopt;
  const int x = side_ == SonarSide::kStarboard ? waterfall_.nadir_column + moved : waterfall_.nadir_column - 1 - moved;
  if (waterfall_.valid.at<unsigned char>(row, x) == 0) return std::nullopt;
  return grey_.at<unsigned char>(row, x);
}

double skew_of(const SwathView& upright, const cv::Range& rows, const cv::Range& columns, double level) {
  double n = 0, r = 0, c = 0, rr = 0, rc = 0, cc = 0;
  for (int row = rows.start; row < rows.end; ++row) {
    for (int column = columns.start; column < columns.end; ++column) {
      if (upright.level(row, column).value_or(0) < level) continue;
      n += 1;
      r += row;
      c += column;
      rr += static_cast<double>(row) * row;
      rc += static_cast<double>(row) * column;
      cc += static_cast<double>(column) * column;
    }
  }
  if (n < 4) return 0;
  const double row_square = rr - r * r / n;
  const double column_square = cc - c * c / n;
  const double product = rc - r * c / n;
  if (!(row_square > 0)) return 0;
  const double skew = product / row_square;
  const double error_square = (column_square - skew * product) / ((n - 2) * row_square);
  return skew * skew > 9.0 * error_square ? skew : 0.0;
}

int RangeProfile::brightest(const cv::Range& columns) const {
  const auto begin = grey.begin() + columns.start;
  return static_cast<int>(std::max_element(begin, grey.begin() + columns.end) - grey.begin());
}

RangeProfile range_profile(const SwathView& view, const cv::Range& rows) {
  const auto columns = static_cast<std::size_t>(view.columns());
  RangeProfile profile{std::vector<double>(columns, 0.0), std::vector<bool>(columns, false)};
  for (std::size_t k = 0; k < columns; ++k) {
    int count = 0;
    for (int row = rows.start; row < rows.end; ++row) {
      const std::optional<double> level = view.level(row, static_cast<int>(k));
      if (!level) continue;
      profile.grey[k] += *level;
      ++count;
    }
    profile.recorded[k] = count > 0;
    if (count > 0) profile.grey[k] /= count;
  }
  return profile;
}

std::optional<ShadowEdges> shadow_behind(const RangeProfile& profile, const cv::Range& echo, int gap, double level) {
  const int size = profile.columns();
  const auto is_dark = [&](int k) { return k < size && profile.is_recorded(k) && profile[k] < level; };
  const int last_start = std::min(echo.end + gap, size);
  int first = std::max(echo.start + 1, std::min(profile.brightest(echo) + 1, echo.end - 1 - gap));
  while (first < last_start && !(is_dark(first) && smooth(profile, first + 1) < level)) ++first;
  if (first >= last_start) return std::nullopt;
  int end = first;
  while (end < size && profile.is_recorded(end) && (profile[end] < level || smooth(profile, end) < level)) ++end;
  ShadowEdges edges;
  edges.is_cut = end == size || !profile.is_recorded(end);
  const bool falls = first > 0 && profile[first - 1] > profile[first];
  edges.start = falls ? first - 0.5 + crossing(profile[first - 1], profile[first], level) : first;
  edges.end = edges.is_cut ? end : end - 0.5 + crossing(profile[end - 1], profile[end], level);
  if (!(edges.end > edges.start)) return std::nullopt;
  for (int k = first; k < end; ++k) edges.mean_grey += profile[k] / (end - first);
  return edges;
}

double near_edge(const RangeProfile& profile, const cv::Range& echo, int gap, double start, double seabed_level) {
  // The columns from here to the shadow stand out most of the seabed: one dark column within the echo does not cut it.
  const double level = kEchoOverSeabed * seabed_level;
  const int least = std::max(echo.start - gap, 1);
  int first = std::min(echo.start, profile.columns() - 1);
  double sum = 0;
  double most = 0;
  for (int k = std::min(static_cast<int>(start), profile.columns()) - 1; k >= least && profile.is_recorded(k - 1); --k) {
    sum += profile[k] - level;
    if (!(sum > most)) continue;
    most = sum;
    first = k;
  }
  if (!(profile[first - 1] < level && profile[first] > level)) return first;
  return first - 0.5 + crossing(profile[first - 1], profile[first], 0.5 * (seabed_level + std::max(profile[first], level)));
}

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
  int low = rows.start + (rows.size() - 1) / 2;
  int high = low;
  while (low > first && part(low - 1) >= 0.5) --low;
  while (high + 1 < end && part(high + 1) >= 0.5) ++high;
  RowExtent extent{static_cast<double>(low), high + 1.0};
  if (low > first) extent.first = low - 0.5 + crossing(part(low - 1), part(low), 0.5);
  if (high + 1 < end) extent.end = high + 0.5 + crossing(part(high), part(high + 1), 0.5);
  return extent;
}

}  // namespace ssjs
