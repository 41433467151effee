/// Finds the points near a place without looking at the others.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ssjs {

/// Points sorted into square cells. A query costs O(cells in reach * log n + answers); memory is O(n) however far apart the points lie.
class PointGrid {
 public:
  /// points: 2xn, m, finite. cell_m > 0, best about the radius of the queries.
  PointGrid(const Eigen::Ref<const Eigen::Matrix2Xd>& points, double cell_m);

  /// Indices of the points with |point - centre| <= radius_m, ascending.
  [[nodiscard]] std::vector<Eigen::Index> within(const Eigen::Vector2d& centre, double radius_m) const;

 private:
  struct Entry {
    std::int64_t column, row;
    Eigen::Index index;
    Eigen::Vector2d point;
  };
  [[nodiscard]] std::int64_t cell_of(double coordinate_m) const;

  double cell_m_;
  std::vector<Entry> entries_;  ///< ordered by column, row, index
};

}  // namespace ssjs
