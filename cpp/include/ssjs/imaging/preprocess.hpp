/// Uneven gain and low contrast, undone before the threshold. docs/math/segmentation.md (O-6), (O-7)
/// What invalid pixels hold has no say in any result.
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

enum class GainNormalisation { kNone, kColumnMedian, kLocalMean };

struct GainConfig {
  GainNormalisation kind = GainNormalisation::kNone;
  int window_px = 129;
  double target_level = 64;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("kind", kind,
             Choices<GainNormalisation>{{"none", GainNormalisation::kNone},
                                        {"column_median", GainNormalisation::kColumnMedian},
                                        {"local_mean", GainNormalisation::kLocalMean}},
             "what every pixel is divided by: nothing, the median of its column (across-track range), the mean around it");
    v.field("window_px", window_px, Rule::at_least(3), "side of the local mean's square, odd; well above the size of the objects");
    v.field("target_level", target_level, Rule{0, 255, true, false}, "what the median or mean becomes, of 255");
  }
};

/// 8 bits, whatever the depth before; saturated at 255, 0 where invalid. With kNone the image as in_8_bits() gives it. (O-7)
[[nodiscard]] cv::Mat normalise_gain(const SonarImage& image, const GainConfig& config);

struct PowerLawConfig {
  bool enabled = true;
  double factor = 0.1;
  double exponent = 1.415;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("enabled", enabled, "whether levels x become factor x^exponent");
    v.field("factor", factor, Rule::positive(), "of the power law on levels from 0 to 255");
    v.field("exponent", exponent, Rule::positive(), "above 1 it draws bright levels apart and pushes dark ones together");
  }
};

/// y = factor x^exponent, rounded and saturated at 255, in 8 bits; 16-bit levels are first drawn out from the valid range to 0..255,
/// unrounded. 0 where invalid. Not enabled: the image as in_8_bits() gives it. (O-6)
[[nodiscard]] cv::Mat power_law(const SonarImage& image, const PowerLawConfig& config);

}  // namespace ssjs
