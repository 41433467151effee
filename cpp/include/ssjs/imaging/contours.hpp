/// Contours: edges after Canny, the borders of their components after Moore, and how many of them are small.
/// [canny1986], [gonzalez2018] 11.1, docs/math/segmentation.md (O-8), (O-9)
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

/// The edges (255) of an image. Strong edges have a gradient of more than `high_fraction` of the image's largest, weak ones of more
/// than 0.4 times that, and count where they touch an edge. high_fraction: in [0, 1]. Images of 16 bits are looked at in 8.
/// Gradients that see an invalid pixel (up to 2 px away) count as zero: the border of the valid part is no edge.
[[nodiscard]] cv::Mat canny_edges(const SonarImage& image, double high_fraction);

/// The outer border of one 8-connected component.
struct Contour {
  std::vector<cv::Point> border;  ///< clockwise to the eye from the component's first pixel; neighbours touch, so do last and first
  std::int64_t component_px = 0;  ///< pixels of the component, those inside its border too
};

/// The border of the component that the pixel `first` begins: the first one from top to bottom, then from left to right.
/// A pixel is met once for every time the border comes by: twice on a line, once at its ends.
[[nodiscard]] std::vector<cv::Point> trace_outer_border(const cv::Mat& mask, cv::Point first);

/// One contour for each component of the set pixels, in the order of their first pixels. Holes have no contour of their own.
[[nodiscard]] std::vector<Contour> outer_contours(const cv::Mat& mask);

/// How many contours have fewer than `area_px` pixels. Every component has one outer border: the components are counted, none is traced.
[[nodiscard]] std::int64_t count_small_contours(const cv::Mat& mask, int area_px);

}  // namespace ssjs
