#include "ssjs/imaging/speckle_filter.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kStripRows = 256;  // floating-point copies are made of so many rows at a time

// OpenCV's filters know of no invalid pixels. Near these their answers are replaced by what the same filter makes of the valid
// pixels alone. (O-12)

/// A valid pixel in the window around another one.
struct Neighbour {
  double level = 0;
  double squared_distance_px = 0;
};

/// Replaces the filtered levels of the pixels that an invalid one is near to (in the square of `radius` around them) by
/// answer(level of the pixel, valid neighbours, the pixel among them).
template <class Pixel, class Answer>
void repeat_near_invalid(const SonarImage& image, int radius, const Answer& answer, cv::Mat& filtered) {
  cv::Mat near = image.valid == 0;
  cv::dilate(near, near, cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8U));
  std::vector<Neighbour> neighbours;
  for (int r = 0; r < filtered.rows; ++r) {
    for (int c = 0; c < filtered.cols; ++c) {
      if (near.at<unsigned char>(r, c) == 0 || image.valid.at<unsigned char>(r, c) == 0) continue;
      neighbours.clear();
      for (int y = std::max(r - radius, 0); y <= std::min(r + radius, filtered.rows - 1); ++y) {
        for (int x = std::max(c - radius, 0); x <= std::min(c + radius, filtered.cols - 1); ++x) {
          if (image.valid.at<unsigned char>(y, x) == 0) continue;
          neighbours.push_back(
              {static_cast<double>(image.intensity.at<Pixel>(y, x)), static_cast<double>((y - r) * (y - r) + (x - c) * (x - c))});
        }
      }
      filtered.at<Pixel>(r, c) = cv::saturate_cast<Pixel>(answer(image.intensity.at<Pixel>(r, c), neighbours));
    }
  }
}

template <class Answer>
void repeat_near_invalid(const SonarImage& image, int radius, const Answer& answer, cv::Mat& filtered) {
  if (image.valid.empty()) return;
  if (filtered.depth() == CV_8U) {
    repeat_near_invalid<std::uint8_t>(image, radius, answer, filtered);
  } else {
    repeat_near_invalid<std::uint16_t>(image, radius, answer, filtered);
  }
}

cv::Mat median(const SonarImage& image, const SpeckleFilterConfig& config) {
  if (config.median_px % 2 == 0) throw InvalidArgument("median_px", config.median_px, "must be odd");
  if (image.intensity.depth() == CV_16U && config.median_px > 5)
    throw InvalidArgument("median_px", config.median_px, "must be 3 or 5 for 16-bit images");
  cv::Mat filtered;
  cv::medianBlur(image.intensity, filtered, config.median_px);
  const auto lower_median = [](double, std::vector<Neighbour>& neighbours) {
    const auto middle = neighbours.begin() + static_cast<std::ptrdiff_t>((neighbours.size() - 1) / 2);
    std::nth_element(neighbours.begin(), middle, neighbours.end(),
                     [](const Neighbour& a, const Neighbour& b) { return a.level < b.level; });
    return middle->level;
  };
  repeat_near_invalid(image, config.median_px / 2, lower_median, filtered);
  return filtered;
}

cv::Mat gaussian(const SonarImage& image, double sigma_px) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_px));
  const cv::Size window(2 * radius + 1, 2 * radius + 1);
  cv::Mat filtered;
  if (image.valid.empty()) {
    cv::GaussianBlur(image.intensity, filtered, window, sigma_px, sigma_px);
    return filtered;
  }
  // Weighted mean of the valid pixels: the filtered image, zero where invalid, over the filtered mask.
  filtered.create(image.intensity.size(), image.intensity.type());
  for (int first = 0; first < filtered.rows; first += kStripRows) {
    const int end = std::min(first + kStripRows, filtered.rows);
    const cv::Range seen(std::max(first - radius, 0), std::min(end + radius, filtered.rows));
    cv::Mat levels, weights;
    cv::Mat(image.valid.rowRange(seen) != 0).convertTo(weights, CV_32F, 1.0 / 255);
    image.intensity.rowRange(seen).convertTo(levels, CV_32F);
    levels = levels.mul(weights);
    cv::GaussianBlur(levels, levels, window, sigma_px, sigma_px, cv::BORDER_CONSTANT);
    cv::GaussianBlur(weights, weights, window, sigma_px, sigma_px, cv::BORDER_CONSTANT);
    const cv::Range own(first - seen.start, end - seen.start);
    cv::Mat means = levels.rowRange(own) / cv::max(weights.rowRange(own), 1e-6F);
    means.convertTo(filtered.rowRange(first, end), filtered.type());
  }
  return filtered;
}

cv::Mat bilateral(const SonarImage& image, const SpeckleFilterConfig& config) {
  const int radius = std::max(1, static_cast<int>(std::lround(1.5 * config.sigma_px)));
  cv::Mat filtered;
  if (image.intensity.depth() == CV_8U) {
    cv::bilateralFilter(image.intensity, filtered, 2 * radius + 1, config.sigma_levels, config.sigma_px);
  } else {
    cv::Mat levels, smooth;
    image.intensity.convertTo(levels, CV_32F);
    if (const auto range = intensity_range(image); range && !image.valid.empty())
      levels.setTo(range->lowest, image.valid == 0);  // OpenCV's table of weights spans all levels of the image
    cv::bilateralFilter(levels, smooth, 2 * radius + 1, config.sigma_levels, config.sigma_px);
    smooth.convertTo(filtered, CV_16U);
  }
  const auto weighted_mean = [&](double level, const std::vector<Neighbour>& neighbours) {
    double sum = 0, weights = 0;
    for (const Neighbour& n : neighbours) {
      if (n.squared_distance_px > radius * radius) continue;  // OpenCV's window is round
      const double unlike = (n.level - level) / config.sigma_levels;
      const double weight = std::exp(-0.5 * (n.squared_distance_px / (config.sigma_px * config.sigma_px) + unlike * unlike));
      sum += weight * n.level;
      weights += weight;
    }
    return sum / weights;
  };
  repeat_near_invalid(image, radius, weighted_mean, filtered);
  return filtered;
}

cv::Mat filter(const SonarImage& image, const SpeckleFilterConfig& config) {
  switch (config.kind) {
    case SpeckleFilter::kNone:
      return image.intensity.clone();
    case SpeckleFilter::kMedian:
      return median(image, config);
    case SpeckleFilter::kGaussian:
      return gaussian(image, config.sigma_px);
    case SpeckleFilter::kBilateral:
      return bilateral(image, config);
  }
  throw InvalidArgument("kind", static_cast<double>(config.kind), "must be a speckle filter");
}

}  // namespace

cv::Mat smooth_speckle(const SonarImage& image, const SpeckleFilterConfig& config) {
  check_sonar_image(image);
  throw_if_any(violations(config));
  cv::Mat filtered = filter(image, config);
  if (!image.valid.empty()) filtered.setTo(0, image.valid == 0);
  return filtered;
}

}  // namespace ssjs
