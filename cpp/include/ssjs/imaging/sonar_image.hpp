/// A sonar picture and where it holds a measurement.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

namespace ssjs {

/// The values from and to which an image's valid pixels run.
struct IntensityRange {
  double lowest = 0;
  double highest = 0;
};

/// Rows are pings or beams, columns range samples; nothing here depends on which.
struct SonarImage {
  cv::Mat intensity;  ///< one channel, CV_8U or CV_16U, not empty
  cv::Mat valid;      ///< CV_8U of the same size, nonzero where the pixel is a measurement; empty: everywhere
};

/// Throws InvalidArgument unless the image is as its fields say.
void check_sonar_image(const SonarImage& image);

/// From the darkest to the brightest valid pixel; none if no pixel is valid.
[[nodiscard]] std::optional<IntensityRange> intensity_range(const SonarImage& image);

/// The image in 8 bits: as it is if it has 8, otherwise its valid range drawn out linearly to 0..255 (rounded; invalid pixels are 0).
[[nodiscard]] SonarImage in_8_bits(const SonarImage& image);

}  // namespace ssjs
