/// Sums of pixels over upright and 45-degree rectangles in constant time. docs/math/cascade.md (C-1), (C-2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ssjs {

/// Running sums of one 8-bit image, all modulo 2^32: sums over any region smaller than 2^24 pixels come out exact, since they
/// themselves fit in 32 bits, whatever the running sums did. Sums of squares: regions up to 66,051 pixels.
///
/// Columns may be stored in `column_step` interleaved planes, so that what windows `column_step` pixels apart need lies side by
/// side: the value that belongs to column x of a row stands at offset(x, 0).
class IntegralImage {
 public:
  enum class Diagonal { kWithout, kWith };

  /// `image`: CV_8UC1, not empty. With `Diagonal::kWith` the sums over triangles are formed, too.
  IntegralImage() = default;
  explicit IntegralImage(const cv::Mat& image, Diagonal diagonal = Diagonal::kWithout, int column_step = 1);

  /// The sums of another picture, in the memory that is there.
  void assign(const cv::Mat& image, Diagonal diagonal, int column_step);

  [[nodiscard]] cv::Size size() const { return size_; }  ///< of the image; the sums have one row and one column more
  [[nodiscard]] int column_step() const { return column_step_; }
  [[nodiscard]] bool has_diagonal() const { return !diagonal_.empty(); }

  /// Where the value of corner (x, y), 0 <= x <= width, 0 <= y <= height, stands in each of the arrays below.
  [[nodiscard]] std::ptrdiff_t offset(int x, int y) const {
    return static_cast<std::ptrdiff_t>(y) * row_length_ + static_cast<std::ptrdiff_t>(x % column_step_) * plane_length_ + x / column_step_;
  }
  [[nodiscard]] const std::uint32_t* sum() const { return sum_.data(); }
  [[nodiscard]] const std::uint32_t* squares() const { return squares_.data(); }
  [[nodiscard]] const std::uint32_t* diagonal() const { return diagonal_.data(); }

  /// Sum of the pixels of an upright rectangle that lies in the image.
  [[nodiscard]] std::uint32_t sum_in(const cv::Rect& rect) const { return difference(sum_, rect); }
  /// Sum of their squares.
  [[nodiscard]] std::uint32_t squares_in(const cv::Rect& rect) const { return difference(squares_, rect); }
  /// Sum over the 45-degree rectangle whose topmost corner is (x, y), `width` diagonal steps down to the right, `height` down to
  /// the left: the pixels of the triangles below the four corners, added and subtracted. Needs `Diagonal::kWith`.
  [[nodiscard]] std::uint32_t diagonal_sum_in(const cv::Rect& rect) const;

 private:
  [[nodiscard]] std::uint32_t difference(const std::vector<std::uint32_t>& sums, const cv::Rect& rect) const;

  cv::Size size_;
  int column_step_ = 1;
  std::ptrdiff_t plane_length_ = 0;
  std::ptrdiff_t row_length_ = 0;
  std::vector<std::uint32_t> sum_;
  std::vector<std::uint32_t> squares_;
  std::vector<std::uint32_t> diagonal_;
};

}  // namespace ssjs
