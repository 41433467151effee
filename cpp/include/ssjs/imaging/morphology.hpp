/// The operations on masks that make regions out of thresholded pixels. [yuan2016] Algorithm 2, docs/math/regions.md
///
/// A mask is one channel of CV_8U, nonzero where set; what lies outside the image is clear. Every result is a new mask of the same
/// size that holds 0 and 255. A mask without pixels gives one without pixels.
#pragma once

#include <opencv2/core.hpp>

namespace ssjs {

/// Without the 8-connected components of fewer than `smallest_area_px` pixels., MATLAB's bwareaopen
[[nodiscard]] cv::Mat remove_small_components(const cv::Mat& mask, int smallest_area_px);

/// Clear pixels are set that join neighbours not joined around them, once, all at the same time., MATLAB's bwmorph 'bridge'
[[nodiscard]] cv::Mat bridge(const cv::Mat& mask);

/// Every pixel is set that has a set one in its square of (2 times + 1) pixels: `times` dilations by a square of 3.
[[nodiscard]] cv::Mat dilate(const cv::Mat& mask, int times);

/// Clear pixels that are not 4-connected to the border are set., MATLAB's imfill 'holes'
[[nodiscard]] cv::Mat fill_holes(const cv::Mat& mask);

}  // namespace ssjs
