#include "ssjs/optical/keypoints.hpp"

#include <dlib/image_keypoint.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "ssjs/base/error.hpp"
#include "ssjs/optical/hessian_pyramid.hpp"
#ifdef SSJS_HAS_FEATURES2D
#include <opencv2/features2d.hpp>
#endif

namespace ssjs {
namespace {

constexpr int kSurfWidth = 64;

/// What a description looks at, as dlib wants it inside the frame, in units of the scale.
constexpr double kDescribedScales = 32.0;

/// Of the mirror image around the frame.
constexpr int kMarginPx = 48;

bool is_inside(const cv::Mat& frame, const cv::Mat& mask, cv::Point2d at) {
  const int column = static_cast<int>(std::lround(at.x));
  const int row = static_cast<int>(std::lround(at.y));
  if (column < 0 || row < 0 || column >= frame.cols || row >= frame.rows) return false;
  return mask.empty() || mask.at<unsigned char>(row, column) != 0;
}

/// Where keypoints may lie: the columns and rows of the mask, all without one. Empty where the mask is clear.
cv::Rect window_of(const cv::Mat& frame, const cv::Mat& mask) {
  return mask.empty() ? cv::Rect({0, 0}, frame.size()) : cv::boundingRect(mask);
}

/// dlib turns and describes what the pyramid finds. The frame is continued by its mirror image, as far as descriptions near its border
/// look, and drawn larger, so that small things are found as well.
Keypoints surf(const cv::Mat& lit, const cv::Mat& mask, const KeypointConfig& config) {
  const int margin = std::min({kMarginPx, lit.cols - 1, lit.rows - 1});
  const double zoom = config.surf_zoom;
  const cv::Rect2d window = window_of(lit, mask);
  Keypoints keypoints;
  keypoints.descriptors.create(0, kSurfWidth, CV_32F);
  if (window.empty()) return keypoints;
  cv::Mat continued;
  cv::copyMakeBorder(lit, continued, margin, margin, margin, margin, cv::BORDER_REFLECT_101);
  if (zoom != 1.0) cv::resize(continued, continued, cv::Size(), zoom, zoom, cv::INTER_LINEAR);
  // Memory that every frame writes over: asking the system for it costs a tenth of the time.
  thread_local IntegralImage integral;
  thread_local HessianPyramid pyramid;
  integral.load(continued);
  // (u + 1/2) zoom - 1/2 is where a resized pixel lies
  const cv::Point2d corner = zoom * (window.tl() + cv::Point2d(margin, margin)) - cv::Point2d(0.5, 0.5);
  pyramid.build(integral, {corner.x, corner.y, zoom * window.width, zoom * window.height});
  std::vector<HessianMaximum> maxima = pyramid.maxima(config.surf_threshold);
  std::stable_sort(maxima.begin(), maxima.end(), [](const auto& a, const auto& b) { return a.determinant > b.determinant; });

  const dlib::rectangle inside(0, 0, integral.nc() - 1, integral.nr() - 1);
  cv::Mat_<float> row(1, kSurfWidth);
  for (const HessianMaximum& maximum : maxima) {
    if (keypoints.points.size() == static_cast<std::size_t>(config.max_keypoints)) break;
    const std::optional<Blob> blob = pyramid.interpolated(maximum);
    if (!blob) continue;
    const cv::Point2d position_px((blob->position_px.x + 0.5) / zoom - 0.5 - margin, (blob->position_px.y + 0.5) / zoom - 0.5 - margin);
    const dlib::vector<double, 2> centre(blob->position_px.x, blob->position_px.y);
    const auto side = static_cast<unsigned long>(kDescribedScales * blob->scale_px);
    if (!is_inside(lit, mask, position_px) || !inside.contains(dlib::centered_rect(centre, side, side))) continue;
    const double angle = dlib::compute_dominant_angle(integral, centre, blob->scale_px);
    dlib::matrix<double, kSurfWidth, 1> description;
    dlib::compute_surf_descriptor(integral, centre, blob->scale_px, angle, description);
    std::transform(description.begin(), description.end(), row.begin(), [](double x) { return static_cast<float>(x); });
    keypoints.descriptors.push_back(row);
    keypoints.points.push_back({position_px, blob->scale_px / zoom, angle, maximum.determinant});
  }
  return keypoints;
}

#ifdef SSJS_HAS_FEATURES2D
Keypoints by_opencv(cv::Feature2D& finder, const cv::Mat& lit, const cv::Mat& mask, const KeypointConfig& config) {
  std::vector<cv::KeyPoint> found;
  finder.detect(lit, found, mask);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.response > b.response; });
  if (found.size() > static_cast<std::size_t>(config.max_keypoints)) found.resize(static_cast<std::size_t>(config.max_keypoints));
  Keypoints keypoints;
  finder.compute(lit, found, keypoints.descriptors);
  for (const cv::KeyPoint& p : found) {
    keypoints.points.push_back({{p.pt.x, p.pt.y}, p.size, p.angle * CV_PI / 180.0, p.response});
  }
  return keypoints;
}
#endif

}  // namespace

bool has_keypoints(KeypointKind kind) {
#ifdef SSJS_HAS_FEATURES2D
  (void)kind;
  return true;
#else
  return kind == KeypointKind::kSurf;
#endif
}

Keypoints find_keypoints(const cv::Mat& lit, const cv::Mat& mask, const KeypointConfig& config) {
  if (lit.empty() || lit.type() != CV_8U)
    throw InvalidArgument("lit", lit.empty() ? "empty" : "another type", "must be CV_8U with one channel");
  if (!mask.empty() && (mask.size() != lit.size() || mask.type() != CV_8U)) {
    throw InvalidArgument("mask", mask.cols, "must be CV_8U and as large as the frame");
  }
  if (config.kind == KeypointKind::kSurf) return surf(lit, mask, config);
#ifdef SSJS_HAS_FEATURES2D
  if (config.kind == KeypointKind::kSift) return by_opencv(*cv::SIFT::create(0, 3, config.sift_contrast), lit, mask, config);
  return by_opencv(*cv::ORB::create(config.max_keypoints), lit, mask, config);
#else
  throw InvalidArgument("keypoints.kind", config.kind == KeypointKind::kSift ? "sift" : "orb",
                        "this build has no OpenCV features2d (Debian: libopencv-features2d-dev): use surf");
#endif
}

}  // namespace ssjs
