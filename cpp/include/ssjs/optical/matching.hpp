/// The same keypoints in two frames, and the motion in the picture that they agree on. docs/math/optical.md (V-12..V-14)
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/optical/keypoints.hpp"

namespace ssjs {

struct MatchingConfig {
  double ratio = 0.85;
  double tolerance_px = 4.0;
  int least_inliers = 10;
  double max_scale_change = 1.5;
  double confidence = 0.999;
  int max_trials = 5000;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("ratio", ratio, Rule{0, 1, true, false}, "a match is kept when its descriptor is nearer than this part of the next best one's");
    v.field("tolerance_px", tolerance_px, Rule::positive(), "a match agrees with a motion that brings its keypoint so near to the other");
    v.field("least_inliers", least_inliers, Rule::at_least(3), "matches that must agree before two frames count as registered");
    v.field("max_scale_change", max_scale_change, Rule{1, 100, true, false}, "between two frames, either way: the altitude's");
    v.field("confidence", confidence, Rule::open(0.0, 1.0), "of having tried a pair of true matches: the search ends there");
    v.field("max_trials", max_trials, Rule::at_least(1), "pairs of matches that are tried at most");
  }
};

/// Row `first` of one frame's keypoints and row `second` of the other's.
struct KeypointMatch {
  int first, second;
  double distance;
};

/// Each is the other's nearest, and clearly nearer than the next one from either side. In the order of `first`. (V-12)
[[nodiscard]] std::vector<KeypointMatch> match_descriptors(const Keypoints& first, const Keypoints& second, double ratio);

/// second_p = scale R(angle) first_p + shift: how a level seabed moves under a camera that looks straight down. (V-13)
struct Similarity {
  double scale = 1.0;
  double angle_rad = 0.0;
  cv::Point2d shift_px;
};
[[nodiscard]] cv::Point2d operator*(const Similarity& second_T_first, cv::Point2d first_px);
[[nodiscard]] cv::Matx33d matrix_of(const Similarity& motion);

/// A point through a homography.
[[nodiscard]] cv::Point2d transformed(const cv::Matx33d& second_H_first, cv::Point2d first_px);

struct Registration {
  Similarity second_T_first;
  cv::Matx33d second_H_first;          ///< homography, affine map or similarity: the richest that the inliers carry (V-14)
  std::vector<KeypointMatch> inliers;  ///< matches that agree with it
  double rms_px = 0.0;                 ///< of the inliers about the similarity
};

/// The motion that most matches agree on, refined over all of them; none when fewer than `least_inliers` do. The same input and seed give
/// the same motion. (V-13), (V-14)
[[nodiscard]] std::optional<Registration> register_frames(const Keypoints& first, const Keypoints& second,
                                                          const std::vector<KeypointMatch>& matches, const MatchingConfig& config,
                                                          std::uint64_t seed = 1);

/// Least squares over pairs of points; two at least, not all in one place.
[[nodiscard]] Similarity fit_similarity(const std::vector<cv::Point2d>& first_px, const std::vector<cv::Point2d>& second_px);

/// The same for an affine map (last row 0, 0, 1); none for fewer than three points or points on a line.
[[nodiscard]] std::optional<cv::Matx33d> fit_affine(const std::vector<cv::Point2d>& first_px, const std::vector<cv::Point2d>& second_px);

/// The same for a homography, H(2, 2) = 1, by the direct linear transform on coordinates brought to mean 0 and mean length sqrt(2); none
/// for fewer than four points, or when it takes the origin to infinity. [hartley2003] 4.4 (V-14)
[[nodiscard]] std::optional<cv::Matx33d> fit_homography(const std::vector<cv::Point2d>& first_px,
                                                        const std::vector<cv::Point2d>& second_px);

}  // namespace ssjs
