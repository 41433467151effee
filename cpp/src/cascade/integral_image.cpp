#include "ssjs/cascade/integral_image.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Row = std::vector<std::uint32_t>;

/// (C-1): one more row of the running sums of the pixels and of their squares.
void add_row(const unsigned char* pixels, int width, Row& sum, Row& squares) {
  std::uint32_t row_sum = 0;
  std::uint32_t row_squares = 0;
  std::uint32_t* sums = sum.data() + 1;  // apart from each other and from the pixels, which the compiler cannot know
  std::uint32_t* square_sums = squares.data() + 1;
  for (int x = 0; x < width; ++x) {
    const std::uint32_t value = pixels[x];
    row_sum += value;
    row_squares += value * value;
    sums[x] += row_sum;
    square_sums[x] += row_squares;
  }
}

/// (C-2): row y of the triangle sums from rows y - 1 and y - 2; `pixels` and `pixels_above` are image rows y - 1 and y - 2 (none: null).
void next_diagonal_row(const unsigned char* pixels, const unsigned char* pixels_above, const Row& above, const Row& two_above, Row& row) {
  const std::size_t width = row.size() - 1;
  const auto column = [&](std::size_t x) {  // the two pixels of column x - 1 on the axis of the triangle
    return static_cast<std::uint32_t>(pixels[x - 1]) + (pixels_above == nullptr ? 0U : pixels_above[x - 1]);
  };
  row[0] = width > 0 ? above[1] : 0U;  // beyond the left border: the triangle two rows up takes the place of its neighbour
  for (std::size_t x = 1; x < width; ++x) row[x] = above[x - 1] + above[x + 1] - two_above[x] + column(x);
  row[width] = above[width - 1] + column(width);  // and beyond the right one
}

/// Row element x goes to plane x % step.
void deal_out(const Row& row, int step, std::uint32_t* out, std::ptrdiff_t plane_length) {
  if (step == 1) {
    std::copy(row.begin(), row.end(), out);
    return;
  }
  if (step == 2) {
    std::uint32_t* even = out;
    std::uint32_t* odd = out + plane_length;
    const std::uint32_t* from = row.data();
    const std::size_t pairs = row.size() / 2;
    for (std::size_t i = 0; i < pairs; ++i) even[i] = from[2 * i];
    for (std::size_t i = 0; i < pairs; ++i) odd[i] = from[2 * i + 1];
    if (row.size() % 2 != 0) even[pairs] = from[2 * pairs];
    return;
  }
  for (std::size_t x = 0; x < row.size(); ++x)
    out[static_cast<std::ptrdiff_t>(x) % step * plane_length + static_cast<std::ptrdiff_t>(x) / step] = row[x];
}

}  // namespace

IntegralImage::IntegralImage(const cv::Mat& image, Diagonal diagonal, int column_step) { assign(image, diagonal, column_step); }

void IntegralImage::assign(const cv::Mat& image, Diagonal diagonal, int column_step) {
  if (image.empty() || image.type() != CV_8UC1)
    throw InvalidArgument("image", cv::typeToString(image.type()), "must be one 8-bit channel, not empty");
  if (column_step < 1) throw InvalidArgument("column_step", column_step, "must be at least 1");
  size_ = image.size();
  column_step_ = column_step;
  plane_length_ = (size_.width + 1 + column_step - 1) / column_step;
  row_length_ = plane_length_ * column_step;
  const std::size_t count = static_cast<std::size_t>(row_length_) * static_cast<std::size_t>(size_.height + 1);
  for (auto* sums : {&sum_, &squares_, &diagonal_}) sums->resize(sums != &diagonal_ || diagonal == Diagonal::kWith ? count : 0);

  const std::size_t columns = static_cast<std::size_t>(size_.width) + 1;
  const auto store = [&](const Row& row, int y, std::vector<std::uint32_t>& sums) {
    deal_out(row, column_step_, sums.data() + offset(0, y), plane_length_);
  };
  Row sum(columns);
  Row squares(columns);
  Row row(columns);
  Row above(columns);
  Row two_above(columns);
  store(sum, 0, sum_);
  store(squares, 0, squares_);
  if (diagonal == Diagonal::kWith) store(row, 0, diagonal_);
  for (int y = 1; y <= size_.height; ++y) {
    const unsigned char* pixels = image.ptr(y - 1);
    add_row(pixels, size_.width, sum, squares);
    store(sum, y, sum_);
    store(squares, y, squares_);
    if (diagonal == Diagonal::kWithout) continue;
    next_diagonal_row(pixels, y > 1 ? image.ptr(y - 2) : nullptr, above, two_above, row);
    store(row, y, diagonal_);
    std::swap(two_above, above);
    std::swap(above, row);
  }
}

std::uint32_t IntegralImage::difference(const std::vector<std::uint32_t>& sums, const cv::Rect& rect) const {
  const auto at = [&](int x, int y) { return sums[static_cast<std::size_t>(offset(x, y))]; };
  return at(rect.x, rect.y) - at(rect.x + rect.width, rect.y) - at(rect.x, rect.y + rect.height) +
         at(rect.x + rect.width, rect.y + rect.height);
}

std::uint32_t IntegralImage::diagonal_sum_in(const cv::Rect& rect) const {
  const auto at = [&](int x, int y) { return diagonal_[static_cast<std::size_t>(offset(x, y))]; };
  const int w = rect.width;
  const int h = rect.height;
  return at(rect.x, rect.y) - at(rect.x - h, rect.y + h) - at(rect.x + w, rect.y + w) + at(rect.x + w - h, rect.y + w + h);
}

}  // namespace ssjs
