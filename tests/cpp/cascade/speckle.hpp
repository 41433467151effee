/// Pictures for the tests: seafloor-like noise, and windows with an echo and its shadow.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "ssjs/base/random.hpp"

namespace ssjs {

/// Speckle about `mean`: grey levels from the sum of three exponential deviates.
inline cv::Mat speckle(cv::Size size, Rng& rng, double mean = 70) {
  cv::Mat image(size, CV_8U);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double deviate = 0;
      for (int i = 0; i < 3; ++i) deviate -= std::log(1 - rng.uniform());
      image.at<unsigned char>(y, x) = static_cast<unsigned char>(std::min(255.0, mean * deviate / 3));
    }
  return image;
}

/// An echo of size x size / 2 at the left of the box and its shadow at the right; the box is 24/24ths of `size` wide.
inline void draw_object(cv::Mat& image, cv::Rect box, Rng& rng) {
  const double gain = rng.uniform(1.6, 3.0);
  const double shade = rng.uniform(0.15, 0.5);
  const double radius = box.width / 24.0;
  const double cx = box.x + radius * (9 + rng.normal());
  const double cy = box.y + radius * (12 + rng.normal());
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      auto& pixel = image.at<unsigned char>(y, x);
      const double dy = (y - cy) / (5 * radius);
      if (std::hypot((x - cx) / (4 * radius), dy) < 1) pixel = static_cast<unsigned char>(std::min(255.0, pixel * gain + 20 * (gain - 1)));
      if (std::hypot((x - cx - 8 * radius) / (5 * radius), dy) < 1) pixel = static_cast<unsigned char>(pixel * shade);
    }
}

}  // namespace ssjs
