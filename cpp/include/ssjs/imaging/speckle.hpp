/// The speckle of simulated sonar pictures. docs/math/segmentation.md (O-13)
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/random.hpp"

namespace ssjs {

/// Each pixel is its level times a gamma deviate of mean 1 and variance 1 / looks, cut off to 8 bits. levels: CV_32F; looks: CV_8U of the
/// same size, at least 1. Returns CV_8U.
[[nodiscard]] cv::Mat speckled(const cv::Mat& levels, const cv::Mat& looks, Rng rng);

}  // namespace ssjs
