/// One channel of an underwater frame, evenly lit. docs/math/optical.md (V-5), (V-6)
#pragma once

#include <opencv2/core.hpp>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

enum class FrameChannel {
  kGrey,      ///< 0.299 R + 0.587 G + 0.114 B
  kRed,       ///< dies first in water: colour differences of near objects
  kGreen,     ///< reaches farthest in coastal water
  kBlue,      ///< reaches farthest in the open sea
  kContrast,  ///< that of the three with the largest standard deviation in the frame
};

struct FrameConfig {
  FrameChannel channel = FrameChannel::kGrey;
  double light_scale = 0.07;
  double mean_level = 128.0;
  double level_sigma = 45.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("channel", channel,
             Choices<FrameChannel>{{"grey", FrameChannel::kGrey},
                                   {"red", FrameChannel::kRed},
                                   {"green", FrameChannel::kGreen},
                                   {"blue", FrameChannel::kBlue},
                                   {"contrast", FrameChannel::kContrast}},
             "of a colour frame: the one channel that is looked at");
    v.field("light_scale", light_scale, Rule::open(0.0, 0.5),
            "light is what varies over more than this (standard deviation of the smoothing), as a part of the frame's width");
    v.field("mean_level", mean_level, Rule::open(0.0, 255.0), "of an evenly lit frame");
    v.field("level_sigma", level_sigma, Rule::positive(), "standard deviation of its levels");
  }
};

/// frame: CV_8U with one channel, or three in the order red, green, blue. Returns CV_8U, one channel, as it was lit. (V-5)
[[nodiscard]] cv::Mat frame_channel(const cv::Mat& frame, FrameChannel channel);

/// Mean and contrast around every pixel taken out: what is left is the same wherever the lamps point. CV_8U in and out. (V-6)
[[nodiscard]] cv::Mat evenly_lit(const cv::Mat& grey, const FrameConfig& config);

/// The mean around every pixel divided out, contrast left as it is: the grain of bare sand is the same beside a rock as far from it. CV_8U
/// in and out. (V-7)
[[nodiscard]] cv::Mat evenly_bright(const cv::Mat& grey, const FrameConfig& config);

/// What makes a frame worth nothing to a matcher.
struct FrameQuality {
  double mean_level = 0.0;   ///< of 255, as taken
  double level_sigma = 0.0;  ///< standard deviation of the levels as taken
  double sharpness = 0.0;    ///< variance of the Laplacian of the smoothed frame over that of its levels: blur takes it away
};

/// grey: CV_8U, one channel, as frame_channel() gives it.
[[nodiscard]] FrameQuality frame_quality(const cv::Mat& grey);

}  // namespace ssjs
