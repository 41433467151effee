/// Motion over level ground from frames that look straight down, without any other sensor. docs/math/optical.md (V-16..V-19)
///
/// The picture's top is ahead: body x = -v, y = -u from the middle of the frame, times the size of a pixel on the ground. Lengths are
/// metres where the size of a pixel is known, else widths of a frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

struct VisualOdometryConfig {
  std::optional<double> metres_per_px;
  double altitude_sigma = 0.1;
  double scale_sigma = 0.02;
  double pixel_sigma_px = 1.5;
  int independent_matches = 6;
  double unseen_factor = 3.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field(
        "metres_per_px", metres_per_px, Rule::positive(),
        "length of a pixel on the ground at the usual altitude, with the lens corrected; none: not known, lengths are widths of a frame");
    v.field("altitude_sigma", altitude_sigma, Rule::positive(), "how far the altitude strays from the usual one, as a part of it");
    v.field("scale_sigma", scale_sigma, Rule::positive(),
            "of the altitudes' ratio that two registered frames tell: tilt of the camera is in it");
    v.field("pixel_sigma_px", pixel_sigma_px, Rule::positive(), "of a keypoint over level ground: tilt and relief are in it");
    v.field("independent_matches", independent_matches, Rule::at_least(2),
            "matches of two frames share errors (tilt, relief): they are worth no more than so many");
    v.field("unseen_factor", unseen_factor, Rule::positive(),
            "where two frames do not register, velocity is kept, give or take so many times its usual change");
  }
};

/// Matched pixels of two frames, lens corrected, (u, v) from the middle of the frame; one column a match.
struct MatchedFrames {
  int first = 0, second = 0;
  Eigen::Matrix2Xd first_px, second_px;
};

/// How long a pixel of each of `frames` frames is, from the scales between registered ones and an altitude that strays little. Width is
/// that of a frame. (V-17)
[[nodiscard]] Eigen::VectorXd pixel_lengths(int frames, const std::vector<MatchedFrames>& pairs, int width_px,
                                            const VisualOdometryConfig& config);

/// (u, v) from the middle of the frame -> body frame. (V-16)
[[nodiscard]] Eigen::Matrix2Xd body_points(const Eigen::Ref<const Eigen::Matrix2Xd>& pixels, double pixel_length);

/// Pose of the second frame in the first's: the rigid motion of the matches, its covariance no smaller than `independent_matches` of their
/// misfit allow. None where they do not determine it. (V-18)
[[nodiscard]] std::optional<GaussianSe2> frame_motion(const MatchedFrames& pair, const Eigen::VectorXd& pixel_length,
                                                      const VisualOdometryConfig& config);

/// One increment from each frame to the next. motions[i]: from frame i to i + 1, none where they did not register: there the velocity is
/// kept that the last registered frames had, as unsure as its changes are large. (V-19)
/// Throws InvalidArgument when no two frames registered, or times do not increase.
[[nodiscard]] std::vector<GaussianSe2> bridged(const std::vector<std::optional<GaussianSe2>>& motions, const Eigen::VectorXd& time_s,
                                               const VisualOdometryConfig& config);

}  // namespace ssjs
