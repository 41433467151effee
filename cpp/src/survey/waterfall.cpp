#include "ssjs/survey/waterfall.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "ssjs/base/error.hpp"
#include "ssjs/survey/side_scan_geometry.hpp"

namespace ssjs {
namespace {

constexpr int kMostColumns = 1 << 16;  // of a side: beyond it a sample interval is wrong by orders of magnitude
constexpr double kEdge = 1e-6;         // of a sample: edges of columns often fall on samples, to rounding

double sample_spacing_m(const SideScanPing& ping, const SideScanChannel& channel) {
  if (!(channel.sample_interval_s > 0)) throw InvalidArgument("sample_interval_s", channel.sample_interval_s, "must be positive");
  return slant_range_m(ping, channel, 1) - slant_range_m(ping, channel, 0);
}

/// Size of a column and number of columns of a side, from the configuration and where it is silent from the pings.
Waterfall empty_waterfall(const std::vector<SideScanPing>& pings, const WaterfallConfig& config) {
  throw_if_any(violations(config));
  double column_m = config.column_m;
  double farthest_m = 0;
  for (const SideScanPing& ping : pings) {
    for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
      const SideScanChannel* channel = channel_of(ping, side, config.channel_pair);
      if (!channel || channel->samples.empty()) continue;
      const double spacing_m = sample_spacing_m(ping, *channel);
      if (column_m == 0) column_m = spacing_m;
      farthest_m = std::max(farthest_m, slant_range_m(ping, *channel, static_cast<double>(channel->samples.size()) - 0.5));
    }
  }
  if (!(farthest_m > 0))
    throw InvalidArgument("pings", static_cast<double>(pings.size()),
                          "hold no sample of channel pair " + std::to_string(config.channel_pair));
  const double columns = std::ceil((config.range_m > 0 ? config.range_m : farthest_m) / column_m - 1e-9);
  if (!(columns <= kMostColumns)) throw InvalidArgument("column_m", column_m, "makes too many columns; take a larger one or less range");
  Waterfall waterfall;
  waterfall.column_m = column_m;
  waterfall.nadir_column = static_cast<int>(columns);
  waterfall.echo = cv::Mat::zeros(static_cast<int>(pings.size()), 2 * waterfall.nadir_column, CV_32F);
  waterfall.valid = cv::Mat::zeros(waterfall.echo.size(), CV_8U);
  return waterfall;
}

/// (SS-10) The samples whose middles lie in [first, end), or the nearest one; none beyond what was recorded.
std::optional<float> mean_echo(const std::vector<float>& samples, double first, double end) {
  const auto size = static_cast<double>(samples.size());
  if (!(first < size - 0.5) || !(end > -0.5)) return std::nullopt;
  const auto low = static_cast<std::size_t>(std::clamp(std::ceil(first - kEdge), 0.0, size));
  const auto high = static_cast<std::size_t>(std::clamp(std::ceil(end - kEdge), 0.0, size));
  if (low >= high) return samples[static_cast<std::size_t>(std::clamp(std::round(0.5 * (first + end)), 0.0, size - 1))];
  double sum = 0;
  for (std::size_t i = low; i < high; ++i) sum += samples[i];
  return static_cast<float>(sum / static_cast<double>(high - low));
}

/// Fills one side of a row; slant_m gives the slant range of the edge before column k.
template <class SlantOfEdge>
void fill_row(Waterfall& waterfall, int row, const SideScanPing& ping, const SideScanChannel& channel, const SlantOfEdge& slant_m) {
  auto* echo = waterfall.echo.ptr<float>(row);
  auto* valid = waterfall.valid.ptr<unsigned char>(row);
  double first = sample_at_slant_range(ping, channel, slant_m(0));
  for (int k = 0; k < waterfall.nadir_column; ++k) {
    const double end = sample_at_slant_range(ping, channel, slant_m(k + 1));
    if (const std::optional<float> level = mean_echo(channel.samples, first, end); level && std::isfinite(*level)) {
      const int column = channel.side == SonarSide::kStarboard ? waterfall.nadir_column + k : waterfall.nadir_column - 1 - k;
      echo[column] = *level;
      valid[column] = 255;
    }
    first = end;
  }
}

template <class FillRow>
Waterfall filled(const std::vector<SideScanPing>& pings, const WaterfallConfig& config, const FillRow& fill) {
  Waterfall waterfall = empty_waterfall(pings, config);
  for (std::size_t i = 0; i < pings.size(); ++i) {
    for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
      const SideScanChannel* channel = channel_of(pings[i], side, config.channel_pair);
      if (channel && !channel->samples.empty()) fill(waterfall, static_cast<int>(i), pings[i], *channel);
    }
  }
  return waterfall;
}

/// The valid levels, sorted by need.
std::vector<float> valid_levels(const Waterfall& waterfall) {
  std::vector<float> levels;
  for (int r = 0; r < waterfall.echo.rows; ++r) {
    const auto* echo = waterfall.echo.ptr<float>(r);
    const auto* valid = waterfall.valid.ptr<unsigned char>(r);
    for (int c = 0; c < waterfall.echo.cols; ++c) {
      if (valid[c] != 0) levels.push_back(echo[c]);
    }
  }
  return levels;
}

float percentile(std::vector<float>& levels, double percent) {
  const auto place = static_cast<std::ptrdiff_t>(std::lround(0.01 * percent * static_cast<double>(levels.size() - 1)));
  std::nth_element(levels.begin(), levels.begin() + place, levels.end());
  return levels[static_cast<std::size_t>(place)];
}

}  // namespace

double Waterfall::range_m(int column) const {
  return (column >= nadir_column ? column - nadir_column + 0.5 : nadir_column - column - 0.5) * column_m;
}

double Waterfall::column(SonarSide side, double range_m) const {
  return side == SonarSide::kStarboard ? nadir_column + range_m / column_m - 0.5 : nadir_column - range_m / column_m - 0.5;
}

const SideScanChannel* channel_of(const SideScanPing& ping, SonarSide side, int channel_pair) {
  int seen = 0;
  for (const SideScanChannel& channel : ping.channels) {
    if (channel.side == side && seen++ == channel_pair) return &channel;
  }
  return nullptr;
}

Waterfall slant_waterfall(const std::vector<SideScanPing>& pings, const WaterfallConfig& config) {
  return filled(pings, config, [](Waterfall& waterfall, int row, const SideScanPing& ping, const SideScanChannel& channel) {
    fill_row(waterfall, row, ping, channel, [&](int k) { return k * waterfall.column_m; });
  });
}

Waterfall ground_waterfall(const std::vector<SideScanPing>& pings, const WaterfallConfig& config) {
  return filled(pings, config, [](Waterfall& waterfall, int row, const SideScanPing& ping, const SideScanChannel& channel) {
    if (!(ping.altitude_m > 0)) return;
    const double first_m = first_return_m(ping);
    fill_row(waterfall, row, ping, channel, [&](int k) { return std::hypot(k * waterfall.column_m, first_m); });  // (SS-12)
  });
}

SonarImage in_grey(const Waterfall& waterfall, const ToneConfig& config) {
  throw_if_any(violations(config));
  if (!(config.dark_percent < config.bright_percent))
    throw InvalidArgument("dark_percent", config.dark_percent, "must be less than bright_percent");
  SonarImage image{cv::Mat::zeros(waterfall.echo.size(), CV_8U), waterfall.valid.clone()};
  std::vector<float> levels = valid_levels(waterfall);
  if (levels.empty()) return image;
  // (SS-11) the logarithm is taken above a thousandth of the bright level: silence has none
  const double bright = percentile(levels, config.bright_percent);
  const double floor = std::max(1e-3 * bright, 1e-30);
  const auto tone = [&](double level) { return config.curve == ToneCurve::kLogarithmic ? std::log(std::max(level, floor)) : level; };
  const double low = tone(percentile(levels, config.dark_percent));
  const double span = tone(bright) - low;
  if (!(span > 0)) return image;
  for (int r = 0; r < waterfall.echo.rows; ++r) {
    const auto* echo = waterfall.echo.ptr<float>(r);
    const auto* valid = waterfall.valid.ptr<unsigned char>(r);
    auto* grey = image.intensity.ptr<unsigned char>(r);
    for (int c = 0; c < waterfall.echo.cols; ++c) {
      if (valid[c] != 0) grey[c] = static_cast<unsigned char>(std::lround(255 * std::clamp((tone(echo[c]) - low) / span, 0.0, 1.0)));
    }
  }
  return image;
}

SonarImage in_16_bits(const Waterfall& waterfall) {
  SonarImage image{cv::Mat::zeros(waterfall.echo.size(), CV_16U), waterfall.valid.clone()};
  std::vector<float> levels = valid_levels(waterfall);
  if (levels.empty()) return image;
  const double median = percentile(levels, 50);
  if (!(median > 0)) return image;
  waterfall.echo.convertTo(image.intensity, CV_16U, 4096.0 / median);
  return image;
}

}  // namespace ssjs
