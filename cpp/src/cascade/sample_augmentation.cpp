#include "ssjs/cascade/sample_augmentation.hpp"

#include <opencv2/imgproc.hpp>

namespace ssjs {
namespace {

cv::Rect moved_box(const cv::Rect& box, const SampleAugmentationConfig& config, Rng& rng) {
  const double scale = 1 + rng.uniform(-config.scale_spread, config.scale_spread);
  const double shift_x = rng.uniform(-config.shift_spread, config.shift_spread);
  const double shift_y = rng.uniform(-config.shift_spread, config.shift_spread);
  const int width = std::max(1, cvRound(scale * box.width));
  const int height = std::max(1, cvRound(scale * box.height));
  const double centre_x = box.x + (0.5 + shift_x) * box.width;
  const double centre_y = box.y + (0.5 + shift_y) * box.height;
  return {cvRound(centre_x - 0.5 * width), cvRound(centre_y - 0.5 * height), width, height};
}

void change_levels(cv::Mat& picture, const SampleAugmentationConfig& config, Rng& rng) {
  const double gain = 1 + rng.uniform(-config.gain_spread, config.gain_spread);
  for (int y = 0; y < picture.rows; ++y) {
    unsigned char* row = picture.ptr<unsigned char>(y);
    for (int x = 0; x < picture.cols; ++x) {
      const double speckle = 1 + rng.normal(config.multiplicative_noise);
      row[x] = cv::saturate_cast<unsigned char>(gain * row[x] * speckle + rng.normal(config.additive_noise));
    }
  }
}

}  // namespace

WindowSet augmented_windows(const cv::Mat& image, const cv::Rect& box, cv::Size window, std::size_t copies, int recording,
                            const SampleAugmentationConfig& config, Rng rng) {
  throw_if_any(violations(config));
  WindowSet windows(window);
  for (std::size_t copy = 0; copy < copies; ++copy) {
    cv::Mat picture = window_of(image, moved_box(box, config, rng), window);
    const bool flips = config.flip_along_track && rng.uniform() < 0.5;
    if (picture.empty()) continue;
    if (flips) cv::flip(picture, picture, 0);
    change_levels(picture, config, rng);
    windows.add(picture, recording);
  }
  return windows;
}

}  // namespace ssjs
