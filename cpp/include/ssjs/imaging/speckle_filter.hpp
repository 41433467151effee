/// Speckle filters. docs/math/segmentation.md (O-12)
/// What invalid pixels hold has no say in the result.
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

enum class SpeckleFilter { kNone, kMedian, kGaussian, kBilateral };

struct SpeckleFilterConfig {
  SpeckleFilter kind = SpeckleFilter::kNone;
  int median_px = 3;
  double sigma_px = 1.5;
  double sigma_levels = 50;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("kind", kind,
             Choices<SpeckleFilter>{{"none", SpeckleFilter::kNone},
                                    {"median", SpeckleFilter::kMedian},
                                    {"gaussian", SpeckleFilter::kGaussian},
                                    {"bilateral", SpeckleFilter::kBilateral}},
             "what smooths the speckle");
    v.field("median_px", median_px, Rule::closed(3, 31), "side of the median's square, odd; 3 or 5 for 16-bit images");
    v.field("sigma_px", sigma_px, Rule{0, 50, true, false}, "standard deviation of the Gaussian and the bilateral filter");
    v.field("sigma_levels", sigma_levels, Rule::positive(),
            "of the bilateral filter: how unlike a pixel may be and still take part, levels of the image");
  }
};

/// The smoothed levels, of the image's depth; 0 where invalid. Windows are cut off at invalid pixels. (O-12)
[[nodiscard]] cv::Mat smooth_speckle(const SonarImage& image, const SpeckleFilterConfig& config);

}  // namespace ssjs
