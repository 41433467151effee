/// Which frames may show the same ground, by where they are believed to be. docs/math/optical.md (V-21)
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

struct FrameOverlapConfig {
  int revisit_candidates = 6;
  double revisit_sigmas = 1.5;
  double revisit_overlap = 0.75;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("revisit_candidates", revisit_candidates, Rule::not_negative(),
            "earlier frames that a frame is compared with at most, each time the track is better known");
    v.field("revisit_sigmas", revisit_sigmas, Rule::not_negative(), "... that lie within so many standard deviations of both positions");
    v.field("revisit_overlap", revisit_overlap, Rule::positive(), "... of being no farther apart than this part of a frame's width");
  }
};

/// pose (n, 3) x, y, heading; variance (n): of the position in all; frame_width: of a frame on the ground, in the same unit. Pairs
/// (earlier, later) that are at least two frames apart, nearest first for each later one. (V-21)
[[nodiscard]] std::vector<std::array<int, 2>> overlapping_frames(const Eigen::Ref<const Eigen::MatrixX3d>& pose,
                                                                 const Eigen::Ref<const Eigen::VectorXd>& variance, double frame_width,
                                                                 const FrameOverlapConfig& config);

}  // namespace ssjs
