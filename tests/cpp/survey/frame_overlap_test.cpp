#include "ssjs/survey/frame_overlap.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Pairs = std::vector<std::array<int, 2>>;

TEST(FrameOverlapTest, V21_FramesThatMayMeetNearestFirst) {
  Eigen::MatrixX3d pose(5, 3);
  pose << 0, 0, 0, 1, 0, 0, 2, 0, 3, 1.1, 0.2, 3, 0.2, 0.1, 3;
  FrameOverlapConfig config;
  const Eigen::VectorXd sure = Eigen::VectorXd::Zero(5);
  EXPECT_EQ(overlapping_frames(pose, sure, 1.0, config), (Pairs{{1, 3}, {0, 4}}));
  // half a width of uncertainty each: 0.75 + 1.5 sqrt(0.5) = 1.81 widths
  const Eigen::VectorXd unsure = Eigen::VectorXd::Constant(5, 0.25);
  EXPECT_EQ(overlapping_frames(pose, unsure, 1.0, config), (Pairs{{1, 3}, {0, 3}, {0, 4}, {1, 4}, {2, 4}}));
  config.revisit_candidates = 1;
  EXPECT_EQ(overlapping_frames(pose, unsure, 1.0, config), (Pairs{{1, 3}, {0, 4}}));
  EXPECT_THROW((void)overlapping_frames(pose, Eigen::VectorXd::Zero(4), 1.0, config), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
