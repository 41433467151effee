#include "ssjs/cascade/augmentation.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

namespace ssjs {
namespace {

/// `picture` about its centre, larger by `scale`, moved, mirrored at its borders where it does not reach.
cv::Mat resampled(const cv::Mat& picture, double scale, double dx, double dy) {
  const double cx = 0.5 * (picture.cols - 1);
  const double cy = 0.5 * (picture.rows - 1);
  const cv::Mat map = (cv::Mat_<double>(2, 3) << scale, 0, cx * (1 - scale) + dx, 0, scale, cy * (1 - scale) + dy);
  cv::Mat result;
  cv::warpAffine(picture, result, map, picture.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT_101);
  return result;
}

cv::Mat varied(const cv::Mat& picture, const AugmentationConfig& config, bool flip, Rng rng) {
  const double scale = 1 + rng.uniform(-config.scale, config.scale);
  const double dx = rng.uniform(-config.shift_px, config.shift_px);
  const double dy = rng.uniform(-config.shift_px, config.shift_px);
  const double gain = 1 + rng.uniform(-config.gain, config.gain);
  cv::Mat copy = resampled(picture, scale, dx, dy);
  if (flip) {
    cv::Mat turned;
    cv::flip(copy, turned, 0);
    copy = turned;
  }
  for (int y = 0; y < copy.rows; ++y)
    for (int x = 0; x < copy.cols; ++x) {
      auto& pixel = copy.at<unsigned char>(y, x);
      const double level = pixel * gain * (1 + rng.normal(config.multiplicative_noise)) + rng.normal(config.additive_noise);
      pixel = static_cast<unsigned char>(std::lround(std::clamp(level, 0.0, 255.0)));
    }
  return copy;
}

}  // namespace

WindowSet augmented(const WindowSet& windows, const AugmentationConfig& config, const Rng& rng) {
  throw_if_any(violations(config));
  WindowSet all = windows;
  for (int c = 0; c < config.copies; ++c)
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const Rng own = rng.stream("copy " + std::to_string(c) + " of window " + std::to_string(i));
      all.add(varied(windows[i], config, config.flip_along_track && c % 2 == 0, own), windows.recording(i));
    }
  return all;
}

}  // namespace ssjs
