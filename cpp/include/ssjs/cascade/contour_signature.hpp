/// The distance from an object's boundary to its centroid: the thesis' second feature (4.3.1, after [atallah2005]), to look once more
/// at what a cascade has found. docs/math/cascade.md (C-19) to (C-21).
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>

#include "ssjs/imaging/sonar_image.hpp"

namespace ssjs {

constexpr std::size_t kContourHarmonics = 16;
using ContourSpectrum = std::array<double, kContourHarmonics>;

struct ContourSignature {
  static constexpr std::size_t kSamples = 128;
  std::array<double, kSamples> distance{};  ///< evenly along the boundary, mean 1: does not change with scale
  ContourSpectrum spectrum{};  ///< magnitudes of its harmonics 1, 2, ...: nor with rotation, mirroring or where the boundary starts
};

/// Of the largest connected region of a mask (CV_8UC1, nonzero inside). None if no region encloses an area.
[[nodiscard]] std::optional<ContourSignature> contour_signature(const cv::Mat& mask);

/// (C-21): the echo in a box of an 8-bit picture, 255 where it is, its longer side kEchoSide pixels. Pixels that are not valid are
/// never echo. None if the box holds one level only. Throws InvalidArgument unless the box lies in the picture.
constexpr int kEchoSide = 64;
[[nodiscard]] std::optional<cv::Mat> echo_mask(const SonarImage& image, const cv::Rect& box);

/// Of the echo in a box; none if there is none.
[[nodiscard]] std::optional<ContourSignature> echo_signature(const SonarImage& image, const cv::Rect& box);

}  // namespace ssjs
