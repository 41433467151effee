/// Where the objects of a picture truly are: drawn as masks or as boxes.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/imaging/mask_components.hpp"

namespace ssjs {

struct TruthObject {
  std::vector<MaskRun> runs;  ///< its pixels, from top to bottom; `component` is its index among the objects
  std::int64_t area_px = 0;
  cv::Point2d centroid_px;  ///< of its pixels; x right, y down, centre of the top left pixel (0, 0)
  cv::Rect bounding_box;
};

/// The objects of a picture without one are an empty list. Boxes may overlap.
struct GroundTruth {
  cv::Size size;          ///< of the picture, pixels
  bool is_boxes = false;  ///< the pixels are those of boxes around the objects: their outlines are not known
  std::vector<TruthObject> objects;
};

/// One object for each 8-connected component of the set pixels. mask: CV_8U, nonzero where set.
[[nodiscard]] GroundTruth truth_of_mask(const cv::Mat& mask);

/// One object for each value that is not 0, in ascending order, connected or not. labels: CV_8U, CV_16U or CV_32S; none negative.
[[nodiscard]] GroundTruth truth_of_labels(const cv::Mat& labels);

/// Boxes in pixels, clipped to the picture. Throws InvalidArgument for one of which nothing is left.
[[nodiscard]] GroundTruth truth_of_boxes(const cv::Size& size, const std::vector<cv::Rect>& boxes);

}  // namespace ssjs
