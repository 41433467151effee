#include "ssjs/geometry/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ssjs/base/error.hpp"

namespace ssjs {

PointGrid::PointGrid(const Eigen::Ref<const Eigen::Matrix2Xd>& points, double cell_m) : cell_m_(cell_m) {
  if (!(cell_m > 0.0) || !std::isfinite(cell_m)) throw InvalidArgument("PointGrid cell_m", cell_m, "must be positive and finite");
  if (!points.allFinite()) throw InvalidArgument("PointGrid points", "NaN or infinity", "every coordinate must be finite");
  entries_.reserve(static_cast<std::size_t>(points.cols()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    entries_.push_back({cell_of(points(0, i)), cell_of(points(1, i)), i, points.col(i)});
  }
  std::sort(entries_.begin(), entries_.end(),
            [](const Entry& a, const Entry& b) { return std::tie(a.column, a.row, a.index) < std::tie(b.column, b.row, b.index); });
}

std::int64_t PointGrid::cell_of(double coordinate_m) const {
  // far beyond any map the cells end: clamping keeps the order, which is all the search needs
  constexpr double kLastCell = 4.0e18;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate_m / cell_m_), -kLastCell, kLastCell));
}

std::vector<Eigen::Index> PointGrid::within(const Eigen::Vector2d& centre, double radius_m) const {
  std::vector<Eigen::Index> found;
  if (!centre.allFinite() || !(radius_m >= 0.0)) return found;
  const double squared_radius = radius_m * radius_m;
  const std::int64_t last_column = cell_of(centre.x() + radius_m);
  const std::int64_t first_row = cell_of(centre.y() - radius_m);
  const std::int64_t last_row = cell_of(centre.y() + radius_m);
  const auto not_before = [&](std::int64_t column) {
    return std::lower_bound(entries_.begin(), entries_.end(), std::tie(column, first_row),
                            [](const Entry& entry, const auto& cell) { return std::tie(entry.column, entry.row) < cell; });
  };
  // jumping to the next occupied column keeps a query with a huge radius bounded by the number of points
  std::vector<Entry>::const_iterator entry = not_before(cell_of(centre.x() - radius_m));
  while (entry != entries_.end() && entry->column <= last_column) {
    const std::int64_t column = entry->column;
    if (entry->row < first_row) {
      entry = not_before(column);
      continue;
    }
    for (; entry != entries_.end() && entry->column == column && entry->row <= last_row; ++entry) {
      if ((entry->point - centre).squaredNorm() <= squared_radius) found.push_back(entry->index);
    }
    if (entry != entries_.end() && entry->column == column) entry = not_before(column + 1);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace ssjs
