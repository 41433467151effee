#include "ssjs/imaging/speckle.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

/// A gamma deviate of mean 1 and variance 1 / looks: the mean of `looks` exponential ones. (O-13)
double speckle(Rng& rng, int looks) {
  double product = 1;
  double sum = 0;
  for (int i = 0; i < looks; ++i) {
    product *= 1 - rng.uniform();
    if (product < 1e-200) {
      sum -= std::log(product);
      product = 1;
    }
  }
  return (sum - std::log(product)) / looks;
}

}  // namespace

cv::Mat speckled(const cv::Mat& levels, const cv::Mat& looks, Rng rng) {
  cv::Mat image(levels.size(), CV_8U);
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.cols; ++c) {
      const double level = levels.at<float>(r, c) * speckle(rng, looks.at<unsigned char>(r, c));
      image.at<unsigned char>(r, c) = static_cast<unsigned char>(std::min(level, 255.0));
    }
  }
  return image;
}

}  // namespace ssjs
