#include "ssjs/imaging/local_mean.hpp"

#include <algorithm>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Adds (sign 1) or takes away (sign -1) one row of the image from the sums over the window's height.
template <class Pixel>
void change(LocalSums& columns, const SonarImage& image, int row, std::int64_t sign) {
  const Pixel* levels = image.intensity.ptr<Pixel>(row);
  const unsigned char* valid = image.valid.empty() ? nullptr : image.valid.ptr(row);
  for (int c = 0; c < image.intensity.cols; ++c) {
    if (valid && valid[c] == 0) continue;
    columns.sum[static_cast<std::size_t>(c)] += sign * levels[c];
    columns.count[static_cast<std::size_t>(c)] += sign;
  }
}

/// Sums of `values` over a window that reaches `half` to either side.
void slide(const std::vector<std::int64_t>& values, std::size_t half, std::vector<std::int64_t>& sums) {
  const std::size_t size = values.size();
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < std::min(half, size); ++i) sum += values[i];
  for (std::size_t i = 0; i < size; ++i) {
    if (i + half < size) sum += values[i + half];
    if (i > half) sum -= values[i - half - 1];
    sums[i] = sum;
  }
}

template <class Pixel>
void visit_rows(const SonarImage& image, int half, const std::function<void(int, const LocalSums&)>& use) {
  const int rows = image.intensity.rows;
  const auto size = static_cast<std::size_t>(image.intensity.cols);
  LocalSums columns{std::vector<std::int64_t>(size), std::vector<std::int64_t>(size)};
  LocalSums sums = columns;
  for (int r = 0; r < std::min(half, rows); ++r) change<Pixel>(columns, image, r, 1);
  for (int r = 0; r < rows; ++r) {
    if (half < rows - r) change<Pixel>(columns, image, r + half, 1);
    if (r > half) change<Pixel>(columns, image, r - half - 1, -1);
    slide(columns.sum, static_cast<std::size_t>(half), sums.sum);
    slide(columns.count, static_cast<std::size_t>(half), sums.count);
    use(r, sums);
  }
}

}  // namespace

void for_each_row_of_local_sums(const SonarImage& image, int window_px, const std::function<void(int, const LocalSums&)>& use) {
  check_sonar_image(image);
  if (window_px < 1 || window_px % 2 == 0) throw InvalidArgument("window_px", window_px, "must be odd and positive");
  if (image.intensity.depth() == CV_8U) {
    visit_rows<std::uint8_t>(image, window_px / 2, use);
  } else {
    visit_rows<std::uint16_t>(image, window_px / 2, use);
  }
}

}  // namespace ssjs
