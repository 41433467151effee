/// Random points of a mosaic, referred back to the frames that it is made of. Thesis 5.3, docs/math/optical.md (V-25)
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ssjs {

/// Two frames that were registered.
struct FrameHomography {
  int first = 0, second = 0;
  cv::Matx33d second_H_first;
};

/// Point `point` at this pixel of this frame.
struct MosaicPointSighting {
  int frame = 0, point = 0;
  cv::Point2d pixel;
};

/// `count` points, spread evenly over the ground that the frames show together: each belongs to the frame whose middle is nearest on the
/// map, and is seen by the frames registered with that one, where their registration takes it: with the errors of frames that were matched,
/// and identities that are known. In the order of frames, then points. Throws InvalidArgument when there is no frame or a frame is missing.
[[nodiscard]] std::vector<MosaicPointSighting> mosaic_points(const std::vector<cv::Matx33d>& map_H_frame, cv::Size frame,
                                                             const std::vector<FrameHomography>& links, int count, std::uint64_t seed);

}  // namespace ssjs
