/// The same point of the ground over all frames that show it: matches between pairs of frames, put together. docs/math/optical.md (V-20)
#pragma once

#include <array>
#include <vector>

namespace ssjs {

/// Rows of the keypoints of two frames that show the same.
struct FrameLink {
  int first = 0, second = 0;
  std::vector<std::array<int, 2>> rows;
};

/// By frame, by keypoint: the number of its track, -1 where it was matched with none. Tracks are numbered in the order of their first
/// keypoint. No track holds two keypoints of one frame: of links that would join them the earlier ones count. Throws InvalidArgument for
/// a link to what is not there.
[[nodiscard]] std::vector<std::vector<int>> keypoint_tracks(const std::vector<int>& keypoints_of_frame,
                                                            const std::vector<FrameLink>& links);

/// The tracks to follow as landmarks, ascending: those over most frames first, until every frame shows `per_frame` of them or has no more.
[[nodiscard]] std::vector<int> chosen_tracks(const std::vector<std::vector<int>>& tracks, int per_frame);

}  // namespace ssjs
