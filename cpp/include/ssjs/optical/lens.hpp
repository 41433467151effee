/// What a lens does to the pixels of a pinhole camera, and frames without it. [brown1971], [kannala2006], docs/math/optical.md (V-1..V-4)
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "ssjs/base/pinhole_camera.hpp"

namespace ssjs {

enum class LensModel {
  kPinhole,      ///< no distortion
  kBrown,        ///< k1, k2, p1, p2, k3: OpenCV's and ROS's "plumb_bob", Kalibr's "radtan" (k3 = 0), Bouguet's kc
  kEquidistant,  ///< k1, k2, k3, k4 and a zero: OpenCV's fisheye, Kalibr's and ROS's "equidistant"
};

struct CameraCalibration {
  PinholeCamera camera;
  double skew_px = 0.0;  ///< of the pixels as taken: u gets skew_px y / z more. A corrected frame has none
  LensModel lens = LensModel::kPinhole;
  std::array<double, 5> distortion{};
};

/// Throws InvalidArgument naming what is not positive or not finite, a centre far outside the frame, or when the lens folds inside the
/// frame: then two directions share a pixel, and the calibration is not one of this camera.
void check_calibration(const CameraCalibration& calibration);

/// Where the camera with its lens shows what the ideal one would show at `ideal_px`. (V-2), (V-3)
[[nodiscard]] cv::Point2d distorted(const CameraCalibration& calibration, cv::Point2d ideal_px);

/// The inverse, by Newton's method. (V-4)
[[nodiscard]] cv::Point2d undistorted(const CameraCalibration& calibration, cv::Point2d seen_px);

/// Takes the lens out of whole frames.
class Undistortion {
 public:
  /// Checks the calibration.
  explicit Undistortion(const CameraCalibration& calibration);

  /// frame: 8 bits, one or three channels, of the calibrated size; else InvalidArgument that names both sizes. Bilinear.
  [[nodiscard]] cv::Mat apply(const cv::Mat& frame) const;
  /// CV_8U, nonzero where a corrected frame shows something that was in the frame.
  [[nodiscard]] const cv::Mat& valid() const { return valid_; }

 private:
  cv::Size size_;
  bool is_identity_;
  cv::Mat whole_, fraction_;  ///< where each pixel of the corrected frame is taken from, as cv::remap does it fastest
  cv::Mat valid_;
};

}  // namespace ssjs
