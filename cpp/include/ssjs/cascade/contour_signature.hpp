/// The distance from an object's boundary to its centroid: the thesis' second feature (4.3.1, after [atallah2005]), to look once more
/// at what a cascade has found. docs/math/cascade.md (C-19), (C-20).
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ssjs {

struct ContourSignature {
  static constexpr std::size_t kSamples = 128;
  static constexpr std::size_t kHarmonics = 16;
  std::array<double, kSamples> distance{};    ///< evenly along the boundary, mean 1: does not change with scale
  std::array<double, kHarmonics> spectrum{};  ///< magnitudes of its harmonics 1, 2, ...: nor with rotation or where the boundary starts
};

/// Of the largest connected region of a mask (CV_8UC1, nonzero inside). None if no region encloses an area.
[[nodiscard]] std::optional<ContourSignature> contour_signature(const cv::Mat& mask);

/// Pixels of an 8-bit picture brighter than its two classes' threshold (Otsu): the echo.
[[nodiscard]] cv::Mat highlight_mask(const cv::Mat& picture);

/// What the contours of known objects look like: mean and deviation of each harmonic.
struct SignatureModel {
  std::array<double, ContourSignature::kHarmonics> mean{};
  std::array<double, ContourSignature::kHarmonics> deviation{};
};

/// Throws InvalidArgument with fewer than two signatures.
[[nodiscard]] SignatureModel learn_signature(const std::vector<ContourSignature>& objects);

/// Root mean square of the harmonics' distances from the model, in deviations: about 1 for objects like those learnt from.
[[nodiscard]] double unlikeness(const ContourSignature& signature, const SignatureModel& model);

}  // namespace ssjs
