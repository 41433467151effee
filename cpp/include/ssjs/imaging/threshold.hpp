/// Thresholds between background and foreground. docs/math/segmentation.md (O-1) to (O-5)
/// Each method needs the histogram alone, whatever the size of the image, but the local one, which looks at every pixel's surroundings.
/// A pixel is foreground when its level is ABOVE the threshold. Images of one level, or without a valid pixel, have no threshold.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/histogram.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// The split with the largest variance between its two classes; of equal splits the lowest. [otsu1979], (O-2)
/// Only the levels from `lowest_level` on take part.
[[nodiscard]] std::optional<int> otsu_threshold(const Histogram& histogram, int lowest_level = 0);

/// Midway between the means of the two classes that it makes, reached from midway between the extreme levels. [ridler1978], (O-3)
[[nodiscard]] std::optional<int> iterative_threshold(const Histogram& histogram);

/// The split with the largest sum of the entropies of its two classes; of equal splits the lowest. [kapur1985], (O-4)
[[nodiscard]] std::optional<int> maximum_entropy_threshold(const Histogram& histogram);

struct LocalThresholdConfig {
  int window_px = 51;
  double offset_levels = 20;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("window_px", window_px, Rule::at_least(3), "side of the square around a pixel, odd");
    v.field("offset_levels", offset_levels, Rule::any(),
            "how far above the mean of its square a foreground pixel lies, levels of the image");
  }
};

/// The valid pixels (255) that are more than the offset brighter than the mean of the valid pixels around them. (O-5)
[[nodiscard]] cv::Mat local_foreground(const SonarImage& image, const LocalThresholdConfig& config);

/// The valid pixels (255) whose level is above `threshold`. (O-1)
[[nodiscard]] cv::Mat foreground(const SonarImage& image, int threshold);

}  // namespace ssjs
