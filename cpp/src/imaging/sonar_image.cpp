#include "ssjs/imaging/sonar_image.hpp"

#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

void check_sonar_image(const SonarImage& image) {
  const cv::Mat& intensity = image.intensity;
  if (intensity.empty()) throw InvalidArgument("image", "empty", "must have at least one pixel");
  if (intensity.dims != 2 || intensity.channels() != 1)
    throw InvalidArgument("image", std::to_string(intensity.channels()) + " channels", "must have one channel");
  if (intensity.depth() != CV_8U && intensity.depth() != CV_16U)
    throw InvalidArgument("image", cv::typeToString(intensity.type()), "must hold 8- or 16-bit unsigned integers");
  if (image.valid.empty()) return;
  if (image.valid.type() != CV_8UC1)
    throw InvalidArgument("valid", cv::typeToString(image.valid.type()), "must be a mask of 8-bit integers");
  if (image.valid.size() != intensity.size())
    throw InvalidArgument("valid", std::to_string(image.valid.cols) + " x " + std::to_string(image.valid.rows),
                          "must have the size of the image");
}

std::optional<IntensityRange> intensity_range(const SonarImage& image) {
  check_sonar_image(image);
  if (!image.valid.empty() && cv::countNonZero(image.valid) == 0) return std::nullopt;
  IntensityRange range;
  cv::minMaxLoc(image.intensity, &range.lowest, &range.highest, nullptr, nullptr, image.valid.empty() ? cv::noArray() : image.valid);
  return range;
}

SonarImage in_8_bits(const SonarImage& image) {
  const std::optional<IntensityRange> range = intensity_range(image);
  if (image.intensity.depth() == CV_8U) return image;
  SonarImage narrow{cv::Mat::zeros(image.intensity.size(), CV_8U), image.valid};
  if (!range || range->highest == range->lowest) return narrow;
  const double gain = 255.0 / (range->highest - range->lowest);
  cv::Mat scaled;
  image.intensity.convertTo(scaled, CV_8U, gain, -gain * range->lowest);
  scaled.copyTo(narrow.intensity, image.valid.empty() ? cv::noArray() : image.valid);
  return narrow;
}

}  // namespace ssjs
