/// The lens of an uncalibrated camera from nothing but its own frames: what bends straight seabed bends it differently in two frames that
/// show it in different places. docs/math/optical.md (V-15)
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/optical/lens.hpp"

namespace ssjs {

/// Matched pixels of two frames as taken, row by row.
struct MatchedPixels {
  std::vector<cv::Point2d> first_px, second_px;
};

struct LensEstimate {
  CameraCalibration calibration;  ///< centre in the middle; focal length half the frame's width, as k1 alone matters; the rest 0
  double rms_before_px = 0.0;     ///< of the matches about the homographies, without the lens ...
  double rms_after_px = 0.0;      ///< ... and with it
};

/// The k1 (Brown, normalised by half the width of the frame) under which the pairs agree best with one homography each. Pairs of fewer
/// than 25 matches say too little and are left out; none when fewer than `least_pairs` are left, or when no lens makes them agree better.
/// Errors count up to tolerance_px.
[[nodiscard]] std::optional<LensEstimate> estimate_lens(const std::vector<MatchedPixels>& pairs, cv::Size frame, double tolerance_px,
                                                        int least_pairs = 5);

}  // namespace ssjs
