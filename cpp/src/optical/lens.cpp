#include "ssjs/optical/lens.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr int kMaxNewtonSteps = 50;
constexpr double kConverged = 1e-12;  // in normalised coordinates

/// A point of the normalised image plane (z = 1) behind the lens, and the derivative by where it is before.
struct Bent {
  cv::Point2d point;
  cv::Matx22d J;
};

Bent brown(cv::Point2d p, const std::array<double, 5>& k) {
  const double x = p.x, y = p.y, r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double slope = k[0] + r2 * (2.0 * k[1] + 3.0 * r2 * k[4]);  // of `radial` by r^2
  Bent bent;
  bent.point = {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x), y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
  const double mixed = 2.0 * (x * y * slope + k[2] * x + k[3] * y);
  bent.J = {radial + 2.0 * x * x * slope + 2.0 * k[2] * y + 6.0 * k[3] * x, mixed,  //
            mixed, radial + 2.0 * y * y * slope + 6.0 * k[2] * y + 2.0 * k[3] * x};
  return bent;
}

Bent equidistant(cv::Point2d p, const std::array<double, 5>& k) {
  const double r = std::hypot(p.x, p.y);
  if (r < 1e-9) return {p, cv::Matx22d::eye()};
  const double angle = std::atan(r), a2 = angle * angle;
  const double bent_angle = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  const double slope = 1.0 + a2 * (3.0 * k[0] + a2 * (5.0 * k[1] + a2 * (7.0 * k[2] + a2 * 9.0 * k[3])));
  const double scale = bent_angle / r;
  const double turn = (slope / (1.0 + r * r) - scale) / (r * r);  // d(scale)/dr / r
  return {p * scale, {scale + turn * p.x * p.x, turn * p.x * p.y, turn * p.x * p.y, scale + turn * p.y * p.y}};
}

Bent bend(const CameraCalibration& calibration, cv::Point2d p) {
  switch (calibration.lens) {
    case LensModel::kBrown:
      return brown(p, calibration.distortion);
    case LensModel::kEquidistant:
      return equidistant(p, calibration.distortion);
    case LensModel::kPinhole:
      break;
  }
  return {p, cv::Matx22d::eye()};
}

cv::Point2d to_plane(const PinholeCamera& camera, cv::Point2d px) {
  return {(px.x - camera.centre_x_px) / camera.focal_x_px, (px.y - camera.centre_y_px) / camera.focal_y_px};
}

cv::Point2d to_pixels(const PinholeCamera& camera, cv::Point2d p, double skew_px) {
  return {camera.focal_x_px * p.x + skew_px * p.y + camera.centre_x_px, camera.focal_y_px * p.y + camera.centre_y_px};
}

}  // namespace

void check_calibration(const CameraCalibration& calibration) {
  const PinholeCamera& camera = calibration.camera;
  if (camera.width_px < 1) throw InvalidArgument("width_px", camera.width_px, "must be positive");
  if (camera.height_px < 1) throw InvalidArgument("height_px", camera.height_px, "must be positive");
  const auto positive = [](const char* name, double value) {
    if (!(value > 0.0 && std::isfinite(value))) throw InvalidArgument(name, value, "must be positive and finite");
  };
  positive("focal_x_px", camera.focal_x_px);
  positive("focal_y_px", camera.focal_y_px);
  const auto finite = [](const char* name, double value) {
    if (!std::isfinite(value)) throw InvalidArgument(name, value, "must be finite");
  };
  // Of a part cut out of a larger frame the centre may lie outside, but a camera that does not look near its own picture has wrong units.
  const auto near_frame = [](const char* name, double value, int side_px) {
    if (!(value >= -side_px && value <= 2.0 * side_px))
      throw InvalidArgument(name, value, "must lie in the frame, 0 to " + std::to_string(side_px) + ", or less than its side beside it");
  };
  near_frame("centre_x_px", camera.centre_x_px, camera.width_px);
  near_frame("centre_y_px", camera.centre_y_px, camera.height_px);
  finite("skew_px", calibration.skew_px);
  for (const double k : calibration.distortion) finite("distortion", k);
  constexpr int kSides = 16;  // points along every side of the frame, and as many steps from the centre to each
  for (int i = 0; i < 4 * kSides; ++i) {
    const double along = (i % kSides) / static_cast<double>(kSides);
    const double sides[4][2] = {{along, 0.0}, {1.0, along}, {1.0 - along, 1.0}, {0.0, 1.0 - along}};
    const cv::Point2d border = to_plane(camera, {sides[i / kSides][0] * camera.width_px, sides[i / kSides][1] * camera.height_px});
    for (int step = 1; step <= kSides; ++step) {
      const Bent bent = bend(calibration, border * (step / static_cast<double>(kSides)));
      if (cv::determinant(bent.J) > 0.0 && bent.J(0, 0) > 0.0) continue;
      throw InvalidArgument(
          "distortion", calibration.distortion[0],
          "with these coefficients the lens folds inside the frame: check their order, and that they belong to a frame of " +
              std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px));
    }
  }
}

cv::Point2d distorted(const CameraCalibration& calibration, cv::Point2d ideal_px) {
  return to_pixels(calibration.camera, bend(calibration, to_plane(calibration.camera, ideal_px)).point, calibration.skew_px);
}

cv::Point2d undistorted(const CameraCalibration& calibration, cv::Point2d seen_px) {
  const PinholeCamera& camera = calibration.camera;
  cv::Point2d seen = to_plane(camera, seen_px);
  seen.x -= calibration.skew_px * seen.y / camera.focal_x_px;
  cv::Point2d p = seen;
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    const Bent bent = bend(calibration, p);
    const cv::Vec2d move = bent.J.inv() * cv::Vec2d(seen.x - bent.point.x, seen.y - bent.point.y);  // (V-4)
    p += cv::Point2d(move[0], move[1]);
    if (std::abs(move[0]) + std::abs(move[1]) < kConverged) break;
  }
  return to_pixels(camera, p, 0.0);
}

Undistortion::Undistortion(const CameraCalibration& calibration)
    : size_(calibration.camera.width_px, calibration.camera.height_px),
      is_identity_(calibration.lens == LensModel::kPinhole && calibration.skew_px == 0.0) {
  check_calibration(calibration);
  valid_ = cv::Mat(size_, CV_8U, cv::Scalar(255));
  if (is_identity_) return;
  cv::Mat columns(size_, CV_32F), rows(size_, CV_32F);
  for (int v = 0; v < size_.height; ++v) {
    for (int u = 0; u < size_.width; ++u) {
      const cv::Point2d from = distorted(calibration, {static_cast<double>(u), static_cast<double>(v)});
      columns.at<float>(v, u) = static_cast<float>(from.x);
      rows.at<float>(v, u) = static_cast<float>(from.y);
      if (!(from.x >= 0.0 && from.y >= 0.0 && from.x <= size_.width - 1 && from.y <= size_.height - 1)) valid_.at<unsigned char>(v, u) = 0;
    }
  }
  cv::convertMaps(columns, rows, whole_, fraction_, CV_16SC2);
}

cv::Mat Undistortion::apply(const cv::Mat& frame) const {
  if (frame.size() != size_) {
    const auto text = [](cv::Size size) { return std::to_string(size.width) + " x " + std::to_string(size.height); };
    throw InvalidArgument("frame", text(frame.size()), "the calibration is for " + text(size_) + " pixels");
  }
  if (frame.depth() != CV_8U || (frame.channels() != 1 && frame.channels() != 3)) {
    throw InvalidArgument("frame", "type " + std::to_string(frame.type()), "must have 8 bits and one or three channels");
  }
  if (is_identity_) return frame;
  cv::Mat corrected;
  cv::remap(frame, corrected, whole_, fraction_, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return corrected;
}

}  // namespace ssjs
