/// The regions of a mask with their measures, and the objects that regions are pieces of. [yuan2016] Algorithm 2 steps 5 and 6,
/// docs/math/regions.md
///
/// Pixel coordinates: x counts columns to the right, y rows downwards, the centre of the top left pixel is (0, 0). MATLAB's, and
/// with them the paper's, are larger by one.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

/// An 8-connected component of the set pixels. to
struct Region {
  int label = 0;  ///< its value in LabelledRegions::labels, from 1
  std::int64_t area_px = 0;
  cv::Point2d centroid_px;
  cv::Rect bounding_box;
  double orientation_rad = 0;  ///< of the major axis, from x towards y (clockwise to the eye), in (-pi/2, pi/2]; 0 if the axes are equal
  double major_axis_px = 0;    ///< length of the ellipse with the same second moments, a pixel being a square: at least 2 / sqrt(3)
  double minor_axis_px = 0;
  double mean_intensity = 0;
  double max_intensity = 0;
};

/// Labels run from 1 in the order of the regions' first pixels, from top to bottom, then from left to right.
struct LabelledRegions {
  cv::Mat labels;               ///< CV_32S of the mask's size, 0 in the background
  std::vector<Region> regions;  ///< regions[i] has label i + 1
};

/// Throws InvalidArgument unless the labels are those of the regions.
void check_labelled_regions(const LabelledRegions& labelled);

/// mask: CV_8U, nonzero where set. intensity: CV_8U or CV_16U, one channel, of the same size.
[[nodiscard]] LabelledRegions find_regions(const cv::Mat& mask, const cv::Mat& intensity);

/// How the centroid of an object follows from those of its regions.
enum class CentroidWeighting {
  kRegions,  ///< their plain mean, as in the paper
  kArea,     ///< weighted with their areas: the centroid of all pixels
};

inline const Choices<CentroidWeighting> kCentroidWeightings = {{"regions", CentroidWeighting::kRegions},
                                                               {"area", CentroidWeighting::kArea}};

/// Regions that belong together.
struct RegionObject {
  std::vector<int> labels;  ///< of its regions, ascending
  std::int64_t area_px = 0;
  cv::Point2d centroid_px;
  cv::Rect bounding_box;
};

/// Regions are of one object when a chain of regions leads from one to the other whose neighbours are nearer than `gap_px`: the
/// distance of two regions is that of their nearest pixels, between centres (so regions side by side with one clear column between
/// them are 2 apart, the smallest distance there is). Objects come in the order of their first regions., (R-10)
[[nodiscard]] std::vector<RegionObject> group_regions(const LabelledRegions& labelled, double gap_px, CentroidWeighting weighting);

}  // namespace ssjs
