/// Objects on the seabed as a highlight with its shadow behind it. Thesis 4.3.1, docs/math/regions.md to
///
/// Rows are pings, columns range samples. The towfish passed over column `nadir_column`: from it to the right (starboard) and from
/// the column before it to the left (port) the range grows. Sound comes from there, so a shadow lies beyond what casts it. Ranges
/// are counted in pixels from the nadir, between pixel edges: starboard column c covers c - nadir_column to c - nadir_column + 1.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/sonar_side.hpp"
#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// How the two levels are found that part shadows, seabed and highlights.
enum class EchoLevels {
  kGrey,      ///< given
  kQuantile,  ///< those which given parts of the valid pixels lie below and above
  kOtsu,      ///< three_class_otsu of the valid pixels
};

inline const Choices<EchoLevels> kEchoLevels = {
    {"grey", EchoLevels::kGrey}, {"quantile", EchoLevels::kQuantile}, {"otsu", EchoLevels::kOtsu}};

struct HighlightShadowConfig {
  int median_px = 5;
  EchoLevels levels = EchoLevels::kQuantile;
  int shadow_grey = 20;
  int highlight_grey = 200;
  double shadow_quantile = 0.05;
  double highlight_quantile = 0.98;
  int shadow_dilations = 2;
  int highlight_dilations = 2;
  int smallest_shadow_px = 60;
  int smallest_highlight_px = 40;
  int smallest_contact_px = 3;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("median_px", median_px, Rule::closed(1, 255), "side of the median filter against speckle, odd; 1: none");
    v.choice("levels", levels, kEchoLevels, "what parts shadows, seabed and highlights");
    v.field("shadow_grey", shadow_grey, Rule::closed(0, 255), "grey: a shadow is darker, in 8 bits");
    v.field("highlight_grey", highlight_grey, Rule::closed(0, 255), "grey: a highlight is brighter, in 8 bits");
    v.field("shadow_quantile", shadow_quantile, Rule::open(0, 1), "quantile: a shadow is darker than the level of this quantile");
    v.field("highlight_quantile", highlight_quantile, Rule::open(0, 1),
            "quantile: a highlight is brighter than the level of this quantile");
    v.field("shadow_dilations", shadow_dilations, Rule::not_negative(), "pixels by which shadows are magnified");
    v.field("highlight_dilations", highlight_dilations, Rule::not_negative(), "pixels by which highlights are magnified");
    v.field("smallest_shadow_px", smallest_shadow_px, Rule::not_negative(), "magnified shadows of fewer pixels are dropped");
    v.field("smallest_highlight_px", smallest_highlight_px, Rule::not_negative(), "magnified highlights of fewer pixels are dropped");
    v.field("smallest_contact_px", smallest_contact_px, Rule::at_least(1), "rows in which a shadow touches the far side of its highlight");
  }
};

/// A highlight and the shadow that touches it in most rows. Measures are of the pixels beyond the levels, not of the magnified ones.
struct ShadowedObject {
  SonarSide side = SonarSide::kStarboard;
  cv::Point2d centroid_px;  ///< of the highlight, x right and y down, pixel centres at whole numbers
  cv::Rect highlight_box;
  cv::Rect shadow_box;
  std::int64_t highlight_area_px = 0;
  std::int64_t shadow_area_px = 0;
  int contact_px = 0;  ///< rows in which the two touch
  // In the row of the longest shadow behind the highlight:
  double shadow_start_px = 0;  ///< range of its near edge
  double shadow_tip_px = 0;    ///< range of its far edge
  bool shadow_is_cut = false;  ///< it ends at the image's border or at invalid pixels, and may be longer
};

/// 8-bit grey levels; shadows are below, highlights above.
struct EchoThresholds {
  int shadow_below = 0;
  int highlight_above = 0;
};

struct HighlightShadows {
  std::optional<EchoThresholds> thresholds;  ///< none: no valid pixel, or for "otsu" fewer than three levels
  cv::Mat highlights;                        ///< the candidates, magnified: CV_8U, 0 and 255
  cv::Mat shadows;
  std::vector<ShadowedObject> objects;  ///< port, then starboard; by the first rows of the magnified highlights, then by range
};

/// Throws InvalidArgument on a nadir outside 0 .. columns and on a configuration that contradicts itself. Images of 16 bits are
/// brought to 8 first (in_8_bits). The water column is dark and ends in a bright first return: that is the order of a pit, not of
/// an object, and is not reported.
[[nodiscard]] HighlightShadows highlight_shadow(const SonarImage& image, int nadir_column, const HighlightShadowConfig& config);

}  // namespace ssjs
