/// Overlapping hits of a detector brought together. docs/math/cascade.md (C-15).
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ssjs {

/// A window that passed the whole cascade, in pixels of the picture.
struct WindowHit {
  cv::Rect box;
  double score = 0;
};

/// What the contour in a box says about it.
struct ContourVerdict {
  std::optional<double> distance;  ///< (C-20); none if the box holds no echo
  double score = 0;                ///< (C-23); 0 without an echo
};

/// One object: the mean of the boxes of a group.
struct Detection {
  cv::Rect box;
  double score = 0;                                      ///< greatest of the group
  int neighbours = 0;                                    ///< windows in the group
  std::optional<ContourVerdict> contour = std::nullopt;  ///< where the detector looks at it
};

/// Boxes are alike when their four sides differ by at most `similarity` times the mean of the lesser width and the lesser height;
/// alike to alike makes a group. Groups of `min_neighbours` windows or fewer are dropped, and so are those inside a larger group
/// of more windows: with `min_neighbours` > 0 the boxes are those of OpenCV's groupRectangles. With 0 every hit is a detection.
/// Best score first, then by place.
[[nodiscard]] std::vector<Detection> group_hits(const std::vector<WindowHit>& hits, int min_neighbours, double similarity);

/// Best score first, each hit that is left takes those that it overlaps by more than `max_overlap` of the lesser of the two areas:
/// one detection. Its box is the mean, weighted by score, of those of them with an intersection over union of at least 0.5. Of
/// `min_neighbours` windows or fewer there is no detection. docs/math/cascade.md (C-26).
[[nodiscard]] std::vector<Detection> best_hits(const std::vector<WindowHit>& hits, int min_neighbours, double max_overlap);

}  // namespace ssjs
