#include "ssjs/imaging/threshold.hpp"

#include <cmath>

#include "ssjs/imaging/local_mean.hpp"

namespace ssjs {
namespace {

double ratio(std::int64_t part, std::int64_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

/// Number of pixels and sum of their levels. Both are whole numbers: what is made of them by one division does not
/// depend on the order of summation, and stays when every count is multiplied by the same number.
struct ClassSum {
  std::int64_t pixels = 0;
  std::int64_t levels = 0;

  void add(int level, std::int64_t count) {
    pixels += count;
    levels += level * count;
  }
  [[nodiscard]] double mean() const { return ratio(levels, pixels); }
};

ClassSum operator-(const ClassSum& a, const ClassSum& b) { return {a.pixels - b.pixels, a.levels - b.levels}; }

ClassSum sum_of_levels(const Histogram& histogram, int first, int last) {
  ClassSum sum;
  for (int level = first; level <= last; ++level) sum.add(level, histogram[level]);
  return sum;
}

template <class Pixel>
void mark_foreground(const cv::Mat& intensity, int row, const LocalSums& sums, double offset, cv::Mat& mask) {
  const Pixel* levels = intensity.ptr<Pixel>(row);
  unsigned char* marked = mask.ptr(row);
  for (int c = 0; c < intensity.cols; ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (sums.count[i] == 0) continue;
    const double mean = ratio(sums.sum[i], sums.count[i]);
    marked[c] = levels[c] - mean > offset ? 255 : 0;  // (O-5)
  }
}

}  // namespace

std::optional<int> otsu_threshold(const Histogram& histogram, int lowest_level) {
  const auto occupied = occupied_levels(histogram, lowest_level);
  if (!occupied || occupied->first == occupied->second) return std::nullopt;
  const auto [lowest, highest] = *occupied;
  const ClassSum all = sum_of_levels(histogram, lowest, highest);
  ClassSum background;
  double largest_variance = -1;
  int threshold = lowest;
  for (int level = lowest; level < highest; ++level) {
    background.add(level, histogram[level]);
    const ClassSum object = all - background;
    const double between_means = background.mean() - object.mean();
    const double variance =
        ratio(background.pixels, all.pixels) * ratio(object.pixels, all.pixels) * between_means * between_means;  // (O-2)
    if (variance > largest_variance) {
      largest_variance = variance;
      threshold = level;
    }
  }
  return threshold;
}

std::optional<int> iterative_threshold(const Histogram& histogram) {
  const auto occupied = occupied_levels(histogram);
  if (!occupied || occupied->first == occupied->second) return std::nullopt;
  const auto [lowest, highest] = *occupied;
  const ClassSum all = sum_of_levels(histogram, lowest, highest);
  int threshold = (lowest + highest) / 2;
  ClassSum background = sum_of_levels(histogram, lowest, threshold);
  for (;;) {  // the threshold only ever moves one way, so this ends
    const ClassSum object = all - background;
    const auto next = static_cast<int>(std::floor((background.mean() + object.mean()) / 2));  // (O-3)
    if (next == threshold) return threshold;
    if (next > threshold) {
      const ClassSum joining = sum_of_levels(histogram, threshold + 1, next);
      background = {background.pixels + joining.pixels, background.levels + joining.levels};
    } else {
      background = background - sum_of_levels(histogram, next + 1, threshold);
    }
    threshold = next;
  }
}

std::optional<int> maximum_entropy_threshold(const Histogram& histogram) {
  const auto occupied = occupied_levels(histogram);
  if (!occupied || occupied->first == occupied->second) return std::nullopt;
  const auto [lowest, highest] = *occupied;
  const std::int64_t pixels = sum_of_levels(histogram, lowest, highest).pixels;
  const auto entropy_term = [&](int level) {
    const double p = ratio(histogram[level], pixels);
    return p > 0 ? -p * std::log(p) : 0.0;
  };
  double all_terms = 0;
  for (int level = lowest; level <= highest; ++level) all_terms += entropy_term(level);

  std::int64_t background_pixels = 0;
  double background_terms = 0;
  double largest_entropy = -1;
  int threshold = lowest;
  for (int level = lowest; level < highest; ++level) {
    background_pixels += histogram[level];
    background_terms += entropy_term(level);
    const double w0 = ratio(background_pixels, pixels);
    const double w1 = ratio(pixels - background_pixels, pixels);
    const double entropy = std::log(w0) + background_terms / w0 + std::log(w1) + (all_terms - background_terms) / w1;  // (O-4)
    if (entropy > largest_entropy) {
      largest_entropy = entropy;
      threshold = level;
    }
  }
  return threshold;
}

cv::Mat local_foreground(const SonarImage& image, const LocalThresholdConfig& config) {
  check_sonar_image(image);
  throw_if_any(violations(config));
  cv::Mat mask = cv::Mat::zeros(image.intensity.size(), CV_8U);
  for_each_row_of_local_sums(image, config.window_px, [&](int row, const LocalSums& sums) {
    if (image.intensity.depth() == CV_8U) {
      mark_foreground<std::uint8_t>(image.intensity, row, sums, config.offset_levels, mask);
    } else {
      mark_foreground<std::uint16_t>(image.intensity, row, sums, config.offset_levels, mask);
    }
  });
  if (!image.valid.empty()) mask.setTo(0, image.valid == 0);
  return mask;
}

cv::Mat foreground(const SonarImage& image, int threshold) {
  check_sonar_image(image);
  cv::Mat mask;
  cv::compare(image.intensity, threshold, mask, cv::CMP_GT);  // (O-1)
  if (!image.valid.empty()) mask.setTo(0, image.valid == 0);
  return mask;
}

}  // namespace ssjs
