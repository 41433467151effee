#include "ssjs/imaging/preprocess.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ssjs/imaging/local_mean.hpp"

namespace ssjs {
namespace {

constexpr int kColumnBlock = 64;  // columns whose medians are found together: rows are read in whole cache lines

unsigned char in_byte(double level) { return static_cast<unsigned char>(std::lround(std::clamp(level, 0.0, 255.0))); }

void clear_invalid(const SonarImage& image, cv::Mat& result) {
  if (!image.valid.empty()) result.setTo(0, image.valid == 0);
}

/// Gains below one level are no measurement, and dividing by them would only make noise.
double normalised(double level, double gain, double target) { return level * target / std::max(gain, 1.0); }

template <class Pixel>
void divide_by_local_mean(const SonarImage& image, const GainConfig& config, cv::Mat& result) {
  for_each_row_of_local_sums(image, config.window_px, [&](int row, const LocalSums& around) {
    const Pixel* levels = image.intensity.ptr<Pixel>(row);
    unsigned char* divided = result.ptr(row);
    for (int c = 0; c < image.intensity.cols; ++c) {
      const auto i = static_cast<std::size_t>(c);
      if (around.count[i] == 0) continue;
      const double mean = static_cast<double>(around.sum[i]) / static_cast<double>(around.count[i]);
      divided[c] = in_byte(normalised(levels[c], mean, config.target_level));  // (O-7)
    }
  });
}

/// The valid levels of each column from `first` on, at most kColumnBlock columns.
template <class Pixel>
std::vector<std::vector<Pixel>> valid_levels(const SonarImage& image, int first) {
  const int end = std::min(first + kColumnBlock, image.intensity.cols);
  std::vector<std::vector<Pixel>> columns(static_cast<std::size_t>(end - first));
  for (int r = 0; r < image.intensity.rows; ++r) {
    const Pixel* levels = image.intensity.ptr<Pixel>(r);
    const unsigned char* valid = image.valid.empty() ? nullptr : image.valid.ptr(r);
    for (int c = first; c < end; ++c) {
      if (!valid || valid[c] != 0) columns[static_cast<std::size_t>(c - first)].push_back(levels[c]);
    }
  }
  return columns;
}

template <class Pixel>
double lower_median(std::vector<Pixel>& levels) {
  if (levels.empty()) return 0;
  const auto middle = levels.begin() + static_cast<std::ptrdiff_t>((levels.size() - 1) / 2);
  std::nth_element(levels.begin(), middle, levels.end());
  return *middle;
}

template <class Pixel>
void divide_by_column_median(const SonarImage& image, const GainConfig& config, cv::Mat& result) {
  std::vector<double> medians;
  for (int first = 0; first < image.intensity.cols; first += kColumnBlock) {
    for (std::vector<Pixel>& column : valid_levels<Pixel>(image, first)) medians.push_back(lower_median(column));
  }
  for (int r = 0; r < image.intensity.rows; ++r) {
    const Pixel* levels = image.intensity.ptr<Pixel>(r);
    unsigned char* divided = result.ptr(r);
    for (int c = 0; c < image.intensity.cols; ++c)
      divided[c] = in_byte(normalised(levels[c], medians[static_cast<std::size_t>(c)], config.target_level));  // (O-7)
  }
}

template <class Pixel>
void divide_by_gain(const SonarImage& image, const GainConfig& config, cv::Mat& result) {
  if (config.kind == GainNormalisation::kLocalMean) {
    divide_by_local_mean<Pixel>(image, config, result);
  } else {
    divide_by_column_median<Pixel>(image, config, result);
  }
}

}  // namespace

cv::Mat normalise_gain(const SonarImage& image, const GainConfig& config) {
  check_sonar_image(image);
  throw_if_any(violations(config));
  if (config.kind == GainNormalisation::kNone) return in_8_bits(image).intensity;
  cv::Mat result = cv::Mat::zeros(image.intensity.size(), CV_8U);
  if (image.intensity.depth() == CV_8U) {
    divide_by_gain<std::uint8_t>(image, config, result);
  } else {
    divide_by_gain<std::uint16_t>(image, config, result);
  }
  clear_invalid(image, result);
  return result;
}

cv::Mat power_law(const SonarImage& image, const PowerLawConfig& config) {
  check_sonar_image(image);
  throw_if_any(violations(config));
  if (!config.enabled) return in_8_bits(image).intensity;
  const auto transformed = [&](double level) { return in_byte(config.factor * std::pow(level, config.exponent)); };  // (O-6)
  cv::Mat result = cv::Mat::zeros(image.intensity.size(), CV_8U);
  if (image.intensity.depth() == CV_8U) {
    cv::Mat table(1, 256, CV_8U);
    for (int level = 0; level < 256; ++level) table.at<unsigned char>(level) = transformed(level);
    cv::LUT(image.intensity, table, result);
  } else if (const auto range = intensity_range(image); range && range->lowest < range->highest) {
    std::vector<unsigned char> table(65536);
    for (std::size_t level = 0; level < table.size(); ++level) {
      const double in_range = std::clamp(static_cast<double>(level), range->lowest, range->highest) - range->lowest;
      table[level] = transformed(255 * in_range / (range->highest - range->lowest));
    }
    for (int r = 0; r < result.rows; ++r) {
      const auto* levels = image.intensity.ptr<std::uint16_t>(r);
      std::transform(levels, levels + result.cols, result.ptr(r), [&](std::uint16_t level) { return table[level]; });
    }
  }
  clear_invalid(image, result);
  return result;
}

}  // namespace ssjs
