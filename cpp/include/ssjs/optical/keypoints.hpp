/// Keypoints of a frame with their descriptors: SURF [bay2008], SIFT [lowe2004] or ORB [rublee2011]. docs/math/optical.md (V-11)
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

enum class KeypointKind { kSurf, kSift, kOrb };

struct KeypointConfig {
  KeypointKind kind = KeypointKind::kSurf;
  int max_keypoints = 400;
  double surf_threshold = 10.0;
  double surf_zoom = 1.0;
  double sift_contrast = 0.01;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("kind", kind, Choices<KeypointKind>{{"surf", KeypointKind::kSurf}, {"sift", KeypointKind::kSift}, {"orb", KeypointKind::kOrb}},
             "what is found and how it is described: surf; sift and orb where the program was built with OpenCV's features2d");
    v.field("max_keypoints", max_keypoints, Rule::at_least(1), "the strongest of a frame are kept");
    v.field("surf_threshold", surf_threshold, Rule::not_negative(), "least determinant of the Hessian of a SURF keypoint");
    v.field("surf_zoom", surf_zoom, Rule::closed(0.25, 4), "SURF is looked for in the frame drawn so much larger");
    v.field("sift_contrast", sift_contrast, Rule::positive(), "least contrast of a SIFT keypoint, of 1");
  }
};

struct Keypoint {
  cv::Point2d position_px;
  double scale_px = 0.0;
  double angle_rad = 0.0;  ///< from x towards y
  double response = 0.0;
};

/// A keypoint and the row of its descriptor belong together; the strongest come first.
struct Keypoints {
  std::vector<Keypoint> points;
  cv::Mat descriptors;  ///< CV_32F, 64 (SURF) or 128 (SIFT) wide, compared by distance; CV_8U, 32 wide (ORB), by differing bits
};

/// Whether this build has them.
[[nodiscard]] bool has_keypoints(KeypointKind kind);

/// lit: CV_8U, one channel, evenly lit. mask: CV_8U of the same size, keypoints lie where it is set; empty: anywhere.
/// Throws InvalidArgument for a kind that this build does not have.
[[nodiscard]] Keypoints find_keypoints(const cv::Mat& lit, const cv::Mat& mask, const KeypointConfig& config);

}  // namespace ssjs
