/// One picture of the ground out of many frames. docs/math/optical.md (V-22..V-24)
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

struct MosaicConfig {
  double max_megapixels = 6.0;
  int max_side_px = 8000;
  double light_scale = 0.15;
  double sharpness = 4.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("max_megapixels", max_megapixels, Rule{0.01, 64, false, false}, "of the mosaic: it is drawn smaller where it would be larger");
    v.field("max_side_px", max_side_px, Rule{16, 32000, false, false}, "of its longer side");
    v.field("light_scale", light_scale, Rule::open(0.0, 0.5),
            "the lamps' light is what all frames share, smoothed over this part of their width");
    v.field("sharpness", sharpness, Rule{1, 20, false, false},
            "of the seams: 1 mixes all frames that show a place, more lets the one count that shows it farthest from its border");
  }
};

/// The part of the map that is drawn, in the units of the map: x to the right, y upwards.
struct MosaicWindow {
  double left = 0.0, bottom = 0.0;
  double pixel_length = 1.0;
  cv::Size size_px;
};

/// map_H_frame takes pixels of a frame to the map. The window holds every frame; a pixel is as long as the frames' own where the limits
/// allow, else longer. Throws InvalidArgument when there is no frame, or one that is not wholly ahead of the camera. (V-22)
[[nodiscard]] MosaicWindow mosaic_window(const std::vector<cv::Matx33d>& map_H_frame, cv::Size frame, const MosaicConfig& config);

/// What the lamps do to every frame alike, learnt from as many of them as there are. (V-23)
class LampLight {
 public:
  explicit LampLight(const MosaicConfig& config) : config_(config) {}
  /// frame: CV_8U, one or three channels, all of one size; else InvalidArgument.
  void learn(const cv::Mat& frame);
  /// The frame as lit evenly, and as bright as the mean of all frames.
  [[nodiscard]] cv::Mat evened(const cv::Mat& frame) const;

 private:
  [[nodiscard]] const cv::Mat& light() const;

  MosaicConfig config_;
  cv::Mat sum_;  ///< CV_32F
  int count_ = 0;
  mutable cv::Mat light_;  ///< smoothed mean; empty until it is asked for
};

/// Frames are added one after the other; the memory is that of the picture alone: 16 bytes a pixel (8 for grey).
class MosaicCanvas {
 public:
  /// Throws InvalidArgument for a window without pixels, or other than one or three channels.
  MosaicCanvas(const MosaicWindow& window, int channels, const MosaicConfig& config);

  /// frame: CV_8U with the canvas's channels. valid: CV_8U of its size, what may be used of it, or empty. (V-24)
  void add(const cv::Mat& frame, const cv::Matx33d& map_H_frame, const cv::Mat& valid = {});

  [[nodiscard]] cv::Mat picture() const;  ///< CV_8U, 0 where nothing was seen
  [[nodiscard]] cv::Mat seen() const;     ///< CV_8U, 255 where something was
  [[nodiscard]] const MosaicWindow& window() const { return window_; }

 private:
  MosaicWindow window_;
  MosaicConfig config_;
  cv::Mat sum_, weight_;  ///< CV_32F
};

}  // namespace ssjs
