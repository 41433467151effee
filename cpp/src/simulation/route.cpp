#include "ssjs/simulation/route.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {

Route::Route(const std::vector<Eigen::Vector2d>& waypoints) : points_(waypoints), start_m_(1, 0.0) {
  if (points_.size() < 2) throw InvalidArgument("World.waypoints", std::to_string(points_.size()) + " points", "a path needs at least 2");
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const double length_m = (points_[i] - points_[i - 1]).norm();
    if (!(length_m > 0.0) || !std::isfinite(length_m)) {
      throw InvalidArgument("World.waypoints[" + std::to_string(i) + "]", length_m, "must be finite and differ from the point before");
    }
    start_m_.push_back(start_m_.back() + length_m);
  }
}

Eigen::Vector2d Route::at(double arc_m) const {
  const std::size_t i = leg_at(arc_m);
  return points_[i] + (arc_m - start_m_[i]) * direction(i);
}

double Route::nearest_ahead(const Eigen::Vector2d& p, double arc_m, double window_m) const {
  double nearest_m = arc_m;
  double least = (at(arc_m) - p).squaredNorm();
  const double window_end_m = std::min(arc_m + window_m, length_m());
  for (std::size_t i = leg_at(arc_m); i + 1 < points_.size() && start_m_[i] < window_end_m; ++i) {
    const double along_m = start_m_[i] + direction(i).dot(p - points_[i]);
    const double clamped_m = std::clamp(along_m, std::max(start_m_[i], arc_m), std::max(std::min(start_m_[i + 1], window_end_m), arc_m));
    const double squared = (at(clamped_m) - p).squaredNorm();
    if (squared < least) {
      least = squared;
      nearest_m = clamped_m;
    }
  }
  return nearest_m;
}

std::size_t Route::leg_at(double arc_m) const {
  const std::size_t after = static_cast<std::size_t>(std::upper_bound(start_m_.begin(), start_m_.end(), arc_m) - start_m_.begin());
  return std::clamp<std::size_t>(after, 1, points_.size() - 1) - 1;
}

}  // namespace ssjs
