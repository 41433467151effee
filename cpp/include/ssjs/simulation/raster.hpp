/// Values on a square grid over the plane, taken between its points by their distance.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace ssjs {

/// The value at (row, column) belongs to `from_m` + cell_m * (row, column). Outside the grid that of its border goes on.
template <class T>
class Raster {
 public:
  Raster(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double cell_m)
      : from_m_(from_m),
        cell_m_(cell_m),
        rows_(static_cast<int>((to_m.x() - from_m.x()) / cell_m) + 2),
        columns_(static_cast<int>((to_m.y() - from_m.y()) / cell_m) + 2),
        values_(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_)) {}

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] const Eigen::Vector2d& from_m() const { return from_m_; }
  [[nodiscard]] Eigen::Vector2d point(int row, int column) const { return from_m_ + cell_m_ * Eigen::Vector2d(row, column); }
  [[nodiscard]] T& at(int row, int column) { return values_[index(row, column)]; }
  [[nodiscard]] const T& at(int row, int column) const { return values_[index(row, column)]; }
  [[nodiscard]] const std::vector<T>& values() const { return values_; }

  /// The four values about a point, and how far it lies from the first of them along rows and columns, of a cell.
  struct Cell {
    const T* low;   ///< (row, column) and, behind it, (row, column + 1)
    const T* high;  ///< the same of the next row
    float across, along;
  };
  [[nodiscard]] Cell cell(double x_m, double y_m) const {
    const auto row = static_cast<float>((x_m - from_m_.x()) / cell_m_);
    const auto column = static_cast<float>((y_m - from_m_.y()) / cell_m_);
    const int r = std::clamp(static_cast<int>(row), 0, rows_ - 2);
    const int c = std::clamp(static_cast<int>(column), 0, columns_ - 2);
    const T* low = &values_[index(r, c)];
    return {low, low + columns_, std::clamp(row - static_cast<float>(r), 0.0F, 1.0F),
            std::clamp(column - static_cast<float>(c), 0.0F, 1.0F)};
  }

 private:
  [[nodiscard]] std::size_t index(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

  Eigen::Vector2d from_m_;
  double cell_m_;
  int rows_, columns_;
  std::vector<T> values_;
};

/// a, b, c, d at the corners of a cell (low, low + 1, high, high + 1), mixed by where the point lies in it.
[[nodiscard]] inline float bilinear(float a, float b, float c, float d, float across, float along) {
  const float low = a + along * (b - a);
  const float high = c + along * (d - c);
  return low + across * (high - low);
}

}  // namespace ssjs
