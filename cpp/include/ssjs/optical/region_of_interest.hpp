/// Regions of interest: where a frame has edges, and a hue unlike the rest. Thesis 4.4.1, docs/math/optical.md (V-8..V-10)
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/config_field.hpp"
#include "ssjs/imaging/regions.hpp"

namespace ssjs {

struct RegionOfInterestConfig {
  double smoothing = 0.004;
  double edge_sigmas = 4.5;
  double joining = 0.012;
  double smallest_area = 0.002;
  double largest_area = 0.6;
  double hue_smoothing = 0.02;
  double hue_factor = 1.0;
  double least_saturation = 0.05;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("smoothing", smoothing, Rule::open(0.0, 0.2), "before the edges: standard deviation as a part of the frame's width");
    v.field("edge_sigmas", edge_sigmas, Rule::positive(),
            "an edge is strong where its gradient is so many times the typical one of the frame (its median over 0.6745)");
    v.field("joining", joining, Rule::open(0.0, 0.2), "edges nearer than this part of the width are one region");
    v.field("smallest_area", smallest_area, Rule::open(0.0, 1.0), "smaller regions, as a part of the frame, are insignificant spots");
    v.field("largest_area", largest_area, Rule{0, 1, true, false}, "larger ones are the seabed itself");
    v.field("hue_smoothing", hue_smoothing, Rule::open(0.0, 0.2), "of the hue: standard deviation as a part of the frame's width");
    v.field("hue_factor", hue_factor, Rule::positive(),
            "a hue is unlike the rest when it differs from the frame's mean hue by more than so many "
            "times the mean difference");
    v.field("least_saturation", least_saturation, Rule{0, 1, false, true},
            "of a frame whose mean saturation is less the hue says nothing: the edges alone decide, as in a grey frame");
  }
};

/// Masks are CV_8U, 255 where set, of the frame's size.
struct RegionsOfInterest {
  cv::Mat edge_mask;         ///< of the edge line
  cv::Mat hue_mask;          ///< of the hue line; empty where the frame has no hue, and where the edge line is clear
  cv::Mat mask;              ///< both (V-10)
  LabelledRegions labelled;  ///< the components of `mask`, intensities those of the bright frame
};

/// Strong structure, joined into regions. bright: CV_8U, one channel, as evenly_bright() gives it. (V-8)
[[nodiscard]] cv::Mat edge_regions(const cv::Mat& bright, const RegionOfInterestConfig& config);

/// Hue unlike the mean hue of the frame. Empty where the colours are too grey to tell. colour: CV_8U, red, green, blue. (V-9)
[[nodiscard]] cv::Mat hue_regions(const cv::Mat& colour, const RegionOfInterestConfig& config);

/// frame: as taken (its lens corrected), one channel or three; bright: its channel, evenly bright.
[[nodiscard]] RegionsOfInterest regions_of_interest(const cv::Mat& frame, const cv::Mat& bright, const RegionOfInterestConfig& config);

}  // namespace ssjs
