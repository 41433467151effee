#include "ssjs/optical/hessian_pyramid.hpp"

#include <dlib/matrix.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ssjs {
namespace {

/// Weight of the mixed derivative, which makes up for boxes in place of Gaussians.
constexpr double kMixedWeight = 0.81;

/// Side of a lobe of the filter.
long lobe_px(int octave, int interval) { return (2L << octave) * (interval + 1) + 1; }

/// So many samples at the border of the frame have no determinant: their filter would reach over it.
long border(int interval) { return (3 * (2 * (interval + 1) + 1) + 1) / 2; }

/// A rectangle about a pixel, `width` x `height` (odd), its middle `right` and `below` of it.
struct Box {
  long width, height, right = 0, below = 0;
};

/// sum[k] = (or +=, -=) the box about the pixel `column + k Step` of the row, for k < count.
template <int Sign, long Step>
void add_boxes(const IntegralImage& image, const Box& box, long row, long column, long count, std::int32_t* sum) {
  const long top = row + box.below - box.height / 2, left = column + box.right - box.width / 2;
  const std::uint32_t *above = image.row(top) + left, *last = image.row(top + box.height) + left;
  const std::uint32_t *above_right = above + box.width, *last_right = last + box.width;
  for (long k = 0; k < count; ++k) {
    const long c = k * Step;
    const auto inside = static_cast<std::int32_t>(last_right[c] - last[c] - above_right[c] + above[c]);
    sum[k] = Sign == 0 ? inside : Sign > 0 ? sum[k] + inside : sum[k] - inside;
  }
}

template <int Sign>
void add_boxes(const IntegralImage& image, const Box& box, long row, long column, long step, long count, std::int32_t* sum) {
  if (step == 2) return add_boxes<Sign, 2>(image, box, row, column, count, sum);
  if (step == 4) return add_boxes<Sign, 4>(image, box, row, column, count, sum);
  if (step == 8) return add_boxes<Sign, 8>(image, box, row, column, count, sum);
  return add_boxes<Sign, 16>(image, box, row, column, count, sum);
}

}  // namespace

void IntegralImage::load(const cv::Mat& frame) {
  rows_ = frame.rows;
  columns_ = frame.cols;
  sums_.assign(static_cast<std::size_t>((rows_ + 1) * (columns_ + 1)), 0);
  for (int r = 0; r < frame.rows; ++r) {
    const unsigned char* pixel = frame.ptr(r);
    const std::uint32_t* above = row(r) + 1;
    std::uint32_t* here = sums_.data() + (r + 1) * (columns_ + 1) + 1;
    std::uint32_t of_row = 0;
    for (int c = 0; c < frame.cols; ++c) {
      of_row += pixel[c];
      here[c] = above[c] + of_row;
    }
  }
}

void HessianPyramid::build(const IntegralImage& image, const cv::Rect2d& window) {
  const auto first = [](double from, long step) { return static_cast<long>(std::floor(from / static_cast<double>(step) - 0.5)); };
  const auto end = [](double to, long step) { return static_cast<long>(std::ceil(to / static_cast<double>(step) + 0.5)) + 1; };
  for (int octave = 0; octave < kOctaves; ++octave) {
    Octave& o = octaves_[octave];
    o.step = static_cast<long>(kFirstStep_px) << octave;
    o.rows = image.nr() / o.step;
    o.columns = image.nc() / o.step;
    // A maximum lies within half a step of its sample.
    o.left = first(window.x, o.step);
    o.right = end(window.x + window.width, o.step);
    o.top = first(window.y, o.step);
    o.bottom = end(window.y + window.height, o.step);
    for (int interval = 0; interval < kIntervals; ++interval) {
      o.determinant[interval].resize(static_cast<std::size_t>(o.rows * o.columns));
      fill(image, octave, interval);
    }
  }
}

void HessianPyramid::fill(const IntegralImage& image, int octave, int interval) {
  Octave& o = octaves_[octave];
  const long edge = border(interval), lobe = lobe_px(octave, interval), apart = lobe / 2 + 1;
  const double one = 1.0 / std::pow(3.0 * static_cast<double>(lobe), 2.0);
  const long left = std::max(edge, o.left - 1), right = std::min((image.nc() - edge * o.step + o.step - 1) / o.step, o.right + 1);
  const long top = std::max(edge, o.top - 1), bottom = std::min((image.nr() - edge * o.step + o.step - 1) / o.step, o.bottom + 1);
  const long count = right - left, wide = 2 * lobe - 1;
  if (count <= 0) return;
  for (std::vector<std::int32_t>* row : {&xx_, &yy_, &xy_, &middle_}) row->resize(static_cast<std::size_t>(count));
  std::int32_t *xx = xx_.data(), *yy = yy_.data(), *xy = xy_.data(), *middle = middle_.data();
  for (long row = top; row < bottom; ++row) {
    const long y = row * o.step, x = left * o.step;
    add_boxes<0>(image, {3 * lobe, wide}, y, x, o.step, count, xx);
    add_boxes<0>(image, {lobe, wide}, y, x, o.step, count, middle);
    for (long k = 0; k < count; ++k) xx[k] -= 3 * middle[k];
    add_boxes<0>(image, {wide, 3 * lobe}, y, x, o.step, count, yy);
    add_boxes<0>(image, {wide, lobe}, y, x, o.step, count, middle);
    for (long k = 0; k < count; ++k) yy[k] -= 3 * middle[k];
    add_boxes<0>(image, {lobe, lobe, -apart, apart}, y, x, o.step, count, xy);
    add_boxes<1>(image, {lobe, lobe, apart, -apart}, y, x, o.step, count, xy);
    add_boxes<-1>(image, {lobe, lobe, -apart, -apart}, y, x, o.step, count, xy);
    add_boxes<-1>(image, {lobe, lobe, apart, apart}, y, x, o.step, count, xy);
    double* determinant = o.determinant[interval].data() + row * o.columns + left;
    for (long k = 0; k < count; ++k) {
      const double Dxx = xx[k] * one, Dyy = yy[k] * one, Dxy = xy[k] * one;
      determinant[k] = std::max(Dxx * Dyy - kMixedWeight * Dxy * Dxy, 0.0);
    }
  }
}

std::vector<HessianMaximum> HessianPyramid::maxima(double threshold) const {
  std::vector<HessianMaximum> found;
  for (int octave = 0; octave < kOctaves; ++octave) {
    const Octave& o = octaves_[octave];
    for (int interval = 1; interval < kIntervals - 1; ++interval) {
      const long edge = border(interval + 1) + 1;
      for (long row = std::max(edge, o.top); row < std::min(o.rows - edge, o.bottom); ++row) {
        for (long column = std::max(edge, o.left); column < std::min(o.columns - edge, o.right); ++column) {
          const double* value = &o.determinant[interval][static_cast<std::size_t>(row * o.columns + column)];
          if (*value < threshold || *value < value[-1] || *value < value[1]) continue;  // most samples
          if (is_maximum(octave, interval, row, column)) found.push_back({octave, interval, row, column, *value});
        }
      }
    }
  }
  return found;
}

bool HessianPyramid::is_maximum(int octave, int interval, long row, long column) const {
  const double value = at(octave, interval, row, column);
  for (int i = interval - 1; i <= interval + 1; ++i) {
    for (long r = row - 1; r <= row + 1; ++r) {
      for (long c = column - 1; c <= column + 1; ++c) {
        if (at(octave, i, r, c) > value) return false;
      }
    }
  }
  return true;
}

std::optional<Blob> HessianPyramid::interpolated(const HessianMaximum& m) const {
  const auto d = [&](int i, long r, long c) { return at(m.octave, m.interval + i, m.row + r, m.column + c); };
  const double value = m.determinant;
  dlib::matrix<double, 3, 1> gradient;
  gradient(0) = (d(0, 0, 1) - d(0, 0, -1)) / 2.0;
  gradient(1) = (d(0, 1, 0) - d(0, -1, 0)) / 2.0;
  gradient(2) = (d(1, 0, 0) - d(-1, 0, 0)) / 2.0;
  const double xx = (d(0, 0, 1) + d(0, 0, -1)) - 2 * value;
  const double yy = (d(0, 1, 0) + d(0, -1, 0)) - 2 * value;
  const double ss = (d(1, 0, 0) + d(-1, 0, 0)) - 2 * value;
  const double xy = (d(0, 1, 1) + d(0, -1, -1) - d(0, -1, 1) - d(0, 1, -1)) / 4.0;
  const double xs = (d(1, 0, 1) + d(-1, 0, -1) - d(-1, 0, 1) - d(1, 0, -1)) / 4.0;
  const double ys = (d(1, 1, 0) + d(-1, -1, 0) - d(-1, 1, 0) - d(1, -1, 0)) / 4.0;
  dlib::matrix<double, 3, 3> hessian;
  hessian = xx, xy, xs, xy, yy, ys, xs, ys, ss;
  const dlib::matrix<double, 3, 1> offset = -inv(hessian) * gradient;
  if (!(max(abs(offset)) < 0.5)) return std::nullopt;
  const auto step = static_cast<double>(octaves_[m.octave].step);
  const double lobe = std::pow(2.0, m.octave + 1.0) * (m.interval + offset(2) + 1) + 1;
  const cv::Point2d position_px((static_cast<double>(m.column) + offset(0)) * step, (static_cast<double>(m.row) + offset(1)) * step);
  return Blob{position_px, 1.2 / 9.0 * (3 * lobe)};  // a filter of 9 pixels stands for a Gaussian of sigma 1.2
}

}  // namespace ssjs
