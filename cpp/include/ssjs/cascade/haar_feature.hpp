/// Haar-like features: weighted sums over two or three rectangles of a window. [viola2004], [lienhart2002], thesis 4.3.1,
/// docs/math/cascade.md (C-3) to (C-6).
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/cascade/integral_image.hpp"

namespace ssjs {

struct WeightedRect {
  cv::Rect rect;  ///< window coordinates, px
  float weight = 0;
  friend bool operator==(const WeightedRect& a, const WeightedRect& b) { return a.rect == b.rect && a.weight == b.weight; }
};

/// The rectangles of a `tilted` feature stand at 45 degrees (IntegralImage::diagonal_sum_in); a feature of two rectangles has 0 as
/// the weight of its third.
struct HaarFeature {
  std::array<WeightedRect, 3> rects;
  bool tilted = false;
  friend bool operator==(const HaarFeature& a, const HaarFeature& b) { return a.rects == b.rects && a.tilted == b.tilted; }
};

/// Which features are tried in training.
enum class FeatureSet {
  kBasic,          ///< upright edges, lines and checkers: 162,336 of them in 24 x 24
  kCore,           ///< and wide lines and centre-surround ones
  kAll,            ///< and the tilted ones
  kSideScan,       ///< two regions along the range axis, dark and bright, 1:1 to 8:1, both directions, with and without a gap
  kSideScanBasic,  ///< kSideScan and kBasic
};
[[nodiscard]] std::string to_string(FeatureSet set);

/// Every feature of the set in a window, in a fixed order. Sums over equal pixels cancel in each of them.
[[nodiscard]] std::vector<HaarFeature> enumerate_features(FeatureSet set, cv::Size window);

/// Throws InvalidArgument unless the feature has at least one rectangle and all lie in the window.
void check_feature(const HaarFeature& feature, cv::Size window);

/// The feature that gives on a mirrored window (left to right) what this one gives. None for a tilted feature that touches the left
/// border: the triangles of (C-2) reach one column farther to the left than to the right.
[[nodiscard]] std::optional<HaarFeature> mirrored(const HaarFeature& feature, cv::Size window);

/// (C-4): the reciprocal of area times standard deviation over the window without its outermost pixels; none if the window is too
/// flat to say anything. `top_left` is the window's corner in the image.
[[nodiscard]] std::optional<float> normalisation(const IntegralImage& image, cv::Point top_left, cv::Size window);

/// (C-4) from area x sum of squares - square of sum.
[[nodiscard]] std::optional<float> reciprocal_deviation(double variance, double area);

/// (C-3): the feature's value in the window at `top_left`, times `norm`.
[[nodiscard]] float feature_value(const HaarFeature& feature, const IntegralImage& image, cv::Point top_left, float norm);

/// The four corners whose running sums make up a rectangle: first - second - third + fourth.
[[nodiscard]] std::array<cv::Point, 4> corners(const cv::Rect& rect, bool tilted);

}  // namespace ssjs
