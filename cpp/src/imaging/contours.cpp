#include "ssjs/imaging/contours.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/mask_components.hpp"

namespace ssjs {
namespace {

constexpr double kSmoothingSigmaPx = 0.5;
constexpr double kLowOfHigh = 0.4;
constexpr int kGradientWindowPx = 5;  // what a gradient sees: a square of 3 of pixels that have seen a square of 3

/// Clockwise to the eye from the right, rows counting downwards.
const cv::Point kNeighbours[] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
constexpr int kDirections = 8;
constexpr int kLeft = 4;

double largest_magnitude(const cv::Mat& dx, const cv::Mat& dy) {
  int largest = 0;
  for (int r = 0; r < dx.rows; ++r) {
    const auto* x = dx.ptr<std::int16_t>(r);
    const auto* y = dy.ptr<std::int16_t>(r);
    for (int c = 0; c < dx.cols; ++c) largest = std::max(largest, x[c] * x[c] + y[c] * y[c]);
  }
  return std::sqrt(largest);
}

bool is_set(const cv::Mat& mask, cv::Point p) {
  return p.x >= 0 && p.y >= 0 && p.x < mask.cols && p.y < mask.rows && mask.at<unsigned char>(p) != 0;
}

/// The first direction clockwise from `behind`, which is clear, where a neighbour of `p` is set; behind itself if none is.
int next_direction(const cv::Mat& mask, cv::Point p, int behind) {
  for (int turn = 1; turn < kDirections; ++turn) {
    const int direction = (behind + turn) % kDirections;
    if (is_set(mask, p + kNeighbours[direction])) return direction;
  }
  return behind;
}

/// After a step, where the last clear pixel looked at lies from the new pixel.
int behind_after(int direction) { return (direction + (direction % 2 == 0 ? 6 : 5)) % kDirections; }

}  // namespace

cv::Mat canny_edges(const SonarImage& image, double high_fraction) {
  if (!(high_fraction >= 0 && high_fraction <= 1)) throw InvalidArgument("high_fraction", high_fraction, "must lie in [0, 1]");
  cv::Mat dx, dy;
  {
    cv::Mat smoothed;
    cv::GaussianBlur(in_8_bits(image).intensity, smoothed, {3, 3}, kSmoothingSigmaPx, kSmoothingSigmaPx, cv::BORDER_REPLICATE);
    cv::Sobel(smoothed, dx, CV_16S, 1, 0, 3, 1, 0, cv::BORDER_REPLICATE);
    cv::Sobel(smoothed, dy, CV_16S, 0, 1, 3, 1, 0, cv::BORDER_REPLICATE);
  }
  if (!image.valid.empty()) {
    cv::Mat sees_invalid = image.valid == 0;
    cv::dilate(sees_invalid, sees_invalid, cv::Mat::ones(kGradientWindowPx, kGradientWindowPx, CV_8U));
    dx.setTo(0, sees_invalid);
    dy.setTo(0, sees_invalid);
  }
  const double high = high_fraction * largest_magnitude(dx, dy);  // (O-8)
  cv::Mat edges;
  cv::Canny(dx, dy, edges, kLowOfHigh * high, high, true);
  return edges;
}

std::vector<cv::Point> trace_outer_border(const cv::Mat& mask, cv::Point first) {
  check_mask(mask, "mask");
  if (!is_set(mask, first)) throw InvalidArgument("first", "clear", "must be a pixel of the mask");
  std::vector<cv::Point> border;
  cv::Point pixel = first;
  int behind = kLeft;  // of the first pixel of a component, the left neighbour is clear
  int first_step = -1;
  for (;;) {
    const int step = next_direction(mask, pixel, behind);
    if (pixel == first && step == first_step) return border;  // Jacob's rule: at the beginning again, and about to go on as then
    border.push_back(pixel);
    if (step == behind) return border;  // a pixel without neighbours
    if (first_step < 0) first_step = step;
    pixel += kNeighbours[step];
    behind = behind_after(step);
  }
}

std::vector<Contour> outer_contours(const cv::Mat& mask) {
  const MaskComponents components = foreground_components(mask);
  std::vector<Contour> contours;
  for (const MaskRun& run : components.runs) {
    const auto component = static_cast<std::size_t>(run.component);
    if (component == contours.size()) contours.push_back({trace_outer_border(mask, {run.first, run.row}), 0});
    contours[component].component_px += run.end - run.first;
  }
  return contours;
}

std::int64_t count_small_contours(const cv::Mat& mask, int area_px) {
  const std::vector<std::int64_t> areas_px = component_areas_px(foreground_components(mask));
  return std::count_if(areas_px.begin(), areas_px.end(), [&](std::int64_t component_px) { return component_px < area_px; });  // (O-9)
}

}  // namespace ssjs
