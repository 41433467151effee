/// The connected components of a mask as horizontal runs of pixels. docs/math/regions.md
///
/// A mask is one channel of CV_8U, nonzero where set; what lies outside the image is clear. Runs take memory for what is in the
/// mask, not for its size: 16 bytes each, at most one for two pixels.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ssjs {

/// Throws InvalidArgument, naming the argument, unless it is a mask. An image without pixels is one.
void check_mask(const cv::Mat& mask, const std::string& argument);

/// The pixels of columns [first, end) of a row.
struct MaskRun {
  int row = 0;
  int first = 0;
  int end = 0;
  int component = 0;  ///< 0 .. count - 1
};

/// Runs from top to bottom, then from left to right; components are numbered by their first run.
struct MaskComponents {
  std::vector<MaskRun> runs;
  int count = 0;
};

/// The 8-connected components of the set pixels.
[[nodiscard]] MaskComponents foreground_components(const cv::Mat& mask);

/// The 4-connected components of the clear pixels inside the image.
[[nodiscard]] MaskComponents background_components(const cv::Mat& mask);

/// Pixels of each component.
[[nodiscard]] std::vector<std::int64_t> component_areas_px(const MaskComponents& components);

}  // namespace ssjs
