/// Where SURF looks for keypoints [bay2008]: determinants of the Hessian by box filters, and their maxima over place and scale.
/// docs/math/optical.md (V-11)
///
/// The same numbers to the last bit as dlib's hessian_pyramid and get_interest_points, which look at the whole frame, mirrored border and
/// all, and at every box by itself: that was a third of the time of a frame.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ssjs {

/// Sums over the pixels of rectangles of a frame.
class IntegralImage {
 public:
  using value_type = long;  // NOLINT(readability-identifier-naming): dlib's name

  /// frame: CV_8U, one channel.
  void load(const cv::Mat& frame);

  [[nodiscard]] long nr() const { return rows_; }
  [[nodiscard]] long nc() const { return columns_; }

  /// Rectangle: dlib's, whose descriptions ask for it; inside the frame, of less than 2^31 / 255 pixels.
  template <class Rectangle>
  [[nodiscard]] long get_sum_of_area(const Rectangle& r) const {
    const std::uint32_t *above = row(r.top()), *last = row(r.bottom() + 1);
    return static_cast<std::int32_t>(last[r.right() + 1] - last[r.left()] - above[r.right() + 1] + above[r.left()]);
  }

  /// Sums over the rows above this one, left of each column, modulo 2^32: differences are right.
  [[nodiscard]] const std::uint32_t* row(long number) const { return sums_.data() + number * (columns_ + 1); }

 private:
  long rows_ = 0, columns_ = 0;
  std::vector<std::uint32_t> sums_;  ///< a row and a column more than the frame has
};

/// The sample of a pyramid that is larger than all next to it.
struct HessianMaximum {
  int octave = 0, interval = 0;
  long row = 0, column = 0;
  double determinant = 0.0;
};

/// Place and sigma of what a maximum shows.
struct Blob {
  cv::Point2d position_px;
  double scale_px = 0.0;
};

class HessianPyramid {
 public:
  static constexpr int kOctaves = 4, kIntervals = 6, kFirstStep_px = 2;  ///< as in the paper

  /// window: what lies outside of it need not be found.
  void build(const IntegralImage& image, const cv::Rect2d& window);

  /// Maxima of at least `threshold`, by octave, interval, row and column.
  [[nodiscard]] std::vector<HessianMaximum> maxima(double threshold) const;

  /// Between the samples: the vertex of the parabola through the maximum and its neighbours. None where it lies nearer to another sample.
  [[nodiscard]] std::optional<Blob> interpolated(const HessianMaximum& maximum) const;

 private:
  /// Samples `step` pixels apart. Maxima are looked for in the samples [left, right) x [top, bottom); determinants are known around them.
  struct Octave {
    long step = 0, rows = 0, columns = 0;
    long left = 0, right = 0, top = 0, bottom = 0;
    std::vector<double> determinant[kIntervals];  ///< rows x columns
  };

  void fill(const IntegralImage& image, int octave, int interval);
  [[nodiscard]] double at(int octave, int interval, long row, long column) const {
    const Octave& o = octaves_[octave];
    return o.determinant[interval][static_cast<std::size_t>(row * o.columns + column)];
  }
  [[nodiscard]] bool is_maximum(int octave, int interval, long row, long column) const;

  Octave octaves_[kOctaves];
  std::vector<std::int32_t> xx_, yy_, xy_, middle_;  ///< of a row
};

}  // namespace ssjs
