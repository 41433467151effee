/// A path of straight legs, by arc length.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ssjs {

class Route {
 public:
  /// Throws InvalidArgument for fewer than 2 waypoints or two equal ones in a row. m.
  explicit Route(const std::vector<Eigen::Vector2d>& waypoints);

  [[nodiscard]] double length_m() const { return start_m_.back(); }

  /// The path goes straight on beyond its end.
  [[nodiscard]] Eigen::Vector2d at(double arc_m) const;

  /// Arc length of the point nearest to p among those from arc_m to arc_m + window_m.
  [[nodiscard]] double nearest_ahead(const Eigen::Vector2d& p, double arc_m, double window_m) const;

  /// The leg that starts at this waypoint.
  [[nodiscard]] std::size_t leg_at(double arc_m) const;

 private:
  [[nodiscard]] Eigen::Vector2d direction(std::size_t i) const { return (points_[i + 1] - points_[i]) / (start_m_[i + 1] - start_m_[i]); }

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> start_m_;  ///< arc length at each point
};

}  // namespace ssjs
