#include "ssjs/optical/keypoints.hpp"

#include <dlib/image_keypoint.h>
#include <dlib/image_transforms/assign_image.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#ifdef SSJS_HAS_FEATURES2D
#include <opencv2/features2d.hpp>
#endif

namespace ssjs {
namespace {

constexpr int kSurfWidth = 64;

/// Octaves, intervals and first step of the box filters, as in the paper.
constexpr long kOctaves = 4, kIntervals = 6, kFirstStep = 2;

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

/// dlib finds, turns and describes. The frame is continued by its mirror image, as far as descriptions near its border look, and drawn
/// larger, so that small things are found as well.
Keypoints surf(const cv::Mat& lit, const cv::Mat& mask, const KeypointConfig& config) {
  const int margin = std::min({kMarginPx, lit.cols - 1, lit.rows - 1});
  const double zoom = config.surf_zoom;
  cv::Mat continued;
  cv::copyMakeBorder(lit, continued, margin, margin, margin, margin, cv::BORDER_REFLECT_101);
  if (zoom != 1.0) cv::resize(continued, continued, cv::Size(), zoom, zoom, cv::INTER_LINEAR);
  dlib::array2d<unsigned char> image(continued.rows, continued.cols);
  for (int r = 0; r < continued.rows; ++r) std::copy_n(continued.ptr(r), continued.cols, &image[r][0]);
  // Memory that every frame writes over: asking the system for it costs a tenth of the time.
  thread_local dlib::integral_image integral;
  thread_local dlib::hessian_pyramid pyramid;
  integral.load(image);
  pyramid.build_pyramid(integral, kOctaves, kIntervals, kFirstStep);
  std::vector<dlib::interest_point> found;
  dlib::get_interest_points(pyramid, config.surf_threshold, found);
  const auto in_frame = [&](const dlib::interest_point& p) {  // (u + 1/2) zoom - 1/2 is where a resized pixel lies
    return cv::Point2d((p.center.x() + 0.5) / zoom - 0.5 - margin, (p.center.y() + 0.5) / zoom - 0.5 - margin);
  };
  const auto is_left_out = [&](const dlib::interest_point& p) {
    const auto side = static_cast<unsigned long>(kDescribedScales * p.scale);
    return !is_inside(lit, mask, in_frame(p)) || !dlib::get_rect(integral).contains(dlib::centered_rect(p.center, side, side));
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_left_out), found.end());
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.score > b.score; });

  Keypoints keypoints;
  const auto count = std::min(found.size(), static_cast<std::size_t>(config.max_keypoints));
  keypoints.descriptors.create(static_cast<int>(count), kSurfWidth, CV_32F);
  for (std::size_t i = 0; i < count; ++i) {
    const dlib::interest_point& p = found[i];
    const double angle = dlib::compute_dominant_angle(integral, p.center, p.scale);
    dlib::matrix<double, kSurfWidth, 1> description;
    dlib::compute_surf_descriptor(integral, p.center, p.scale, angle, description);
    float* row = keypoints.descriptors.ptr<float>(static_cast<int>(i));
    for (long k = 0; k < kSurfWidth; ++k) row[k] = static_cast<float>(description(k));
    keypoints.points.push_back({in_frame(p), p.scale / zoom, angle, p.score});
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
