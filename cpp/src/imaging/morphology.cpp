#include "ssjs/imaging/morphology.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/imaging/mask_components.hpp"

namespace ssjs {
namespace {

void fill(cv::Mat& mask, const MaskRun& run, unsigned char value) {
  std::memset(mask.ptr<unsigned char>(run.row) + run.first, value, static_cast<std::size_t>(run.end - run.first));
}

/// A row of a mask as 0 and 255 with a clear pixel at either end; all clear outside the image.
struct PaddedRow {
  std::vector<unsigned char> pixels;
  bool any = false;  ///< is set

  explicit PaddedRow(int columns) : pixels(static_cast<std::size_t>(columns) + 2, 0) {}
  void read(const cv::Mat& mask, int row) {
    unsigned char all = 0;
    const unsigned char* from = row < mask.rows ? mask.ptr<unsigned char>(row) : nullptr;
    for (int x = 0; x < mask.cols && from != nullptr; ++x) all = static_cast<unsigned char>(all | from[x]);
    if (all == 0 && !any) return;  // clear, as before
    any = all != 0;
    unsigned char* to = pixels.data() + 1;
    for (int x = 0; x < mask.cols; ++x) to[x] = any && from[x] != 0 ? 255 : 0;
  }
};

/// as bitwise logic without branches, which compilers turn into 16 pixels at a time.
void bridge_row(const unsigned char* above, const unsigned char* here, const unsigned char* below, unsigned char* out, int columns) {
  for (int x = 0; x < columns; ++x) {
    const unsigned nw = above[x], n = above[x + 1], ne = above[x + 2];
    const unsigned w = here[x], centre = here[x + 1], e = here[x + 2];
    const unsigned sw = below[x], s = below[x + 1], se = below[x + 2];
    // Components of the neighbours, counted where they begin: one after each clear edge neighbour, anticlockwise from the east.
    const unsigned after_e = ~e & (ne | n), after_n = ~n & (nw | w), after_w = ~w & (sw | s), after_s = ~s & (se | e);
    const unsigned two_or_more = (after_e & after_n) | (after_w & after_s) | ((after_e | after_n) & (after_w | after_s));
    const unsigned any_edge = n | e | s | w;
    const unsigned opposite_corners = (nw & se) | (ne & sw);  // lone corners: two of one side are left alone
    out[x] = static_cast<unsigned char>(centre | (any_edge & two_or_more) | (~any_edge & opposite_corners));
  }
}

}  // namespace

cv::Mat remove_small_components(const cv::Mat& mask, int smallest_area_px) {
  if (smallest_area_px < 0) throw InvalidArgument("smallest_area_px", smallest_area_px, "must not be negative");
  const MaskComponents components = foreground_components(mask);
  const std::vector<std::int64_t> area_px = component_areas_px(components);
  cv::Mat kept = cv::Mat::zeros(mask.size(), CV_8U);
  for (const MaskRun& run : components.runs) {
    if (area_px[static_cast<std::size_t>(run.component)] >= smallest_area_px) fill(kept, run, 255);
  }
  return kept;
}

cv::Mat bridge(const cv::Mat& mask) {
  check_mask(mask, "mask");
  cv::Mat bridged = cv::Mat::zeros(mask.size(), CV_8U);
  std::array<PaddedRow, 3> rows{PaddedRow(mask.cols), PaddedRow(mask.cols), PaddedRow(mask.cols)};
  if (!mask.empty()) rows[2].read(mask, 0);
  for (int row = 0; row < mask.rows; ++row) {
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
    rows[2].read(mask, row + 1);
    if (!rows[0].any && !rows[1].any && !rows[2].any) continue;
    bridge_row(rows[0].pixels.data(), rows[1].pixels.data(), rows[2].pixels.data(), bridged.ptr<unsigned char>(row), mask.cols);
  }
  return bridged;
}

cv::Mat dilate(const cv::Mat& mask, int times) {
  check_mask(mask, "mask");
  if (times < 0) throw InvalidArgument("times", times, "must not be negative");
  if (mask.empty()) return cv::Mat(mask.size(), CV_8U);
  cv::Mat dilated = mask != 0;
  const int enough = std::min(times, std::max(mask.rows, mask.cols));                  // by then one set pixel has filled the image
  if (enough > 0) cv::dilate(dilated, dilated, cv::Mat(), cv::Point(-1, -1), enough);
  return dilated;
}

cv::Mat fill_holes(const cv::Mat& mask) {
  const MaskComponents background = background_components(mask);
  std::vector<bool> reaches_border(static_cast<std::size_t>(background.count), false);
  for (const MaskRun& run : background.runs) {
    if (run.row == 0 || run.row == mask.rows - 1 || run.first == 0 || run.end == mask.cols)
      reaches_border[static_cast<std::size_t>(run.component)] = true;
  }
  cv::Mat filled(mask.size(), CV_8U, cv::Scalar(255));
  for (const MaskRun& run : background.runs) {
    if (reaches_border[static_cast<std::size_t>(run.component)]) fill(filled, run, 0);
  }
  return filled;
}

}  // namespace ssjs
