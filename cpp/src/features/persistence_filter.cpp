#include "ssjs/features/persistence_filter.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {

Features PersistenceFilter::confirmed(const Features& scan, const Se2& odometry_T_vehicle) {
  if (config_.min_earlier_sightings == 0) return scan;
  Features kept;
  Points points;
  points.reserve(scan.size());
  for (const Feature& feature : scan) {
    const Eigen::Vector2d vehicle_p_feature = feature.range() * Eigen::Vector2d(std::cos(feature.bearing()), std::sin(feature.bearing()));
    points.push_back(odometry_T_vehicle * vehicle_p_feature);
    if (earlier_sightings(points.back()) >= config_.min_earlier_sightings) kept.push_back(feature);
  }
  earlier_.push_front(std::move(points));
  if (static_cast<int>(earlier_.size()) > config_.window_scans) earlier_.pop_back();
  return kept;
}

int PersistenceFilter::earlier_sightings(const Eigen::Vector2d& odometry_p_feature) const {
  int count = 0;
  double gate_m = config_.gate_m;
  for (const Points& scan : earlier_) {
    const auto is_there = [&](const Eigen::Vector2d& point) { return (point - odometry_p_feature).norm() < gate_m; };
    count += std::any_of(scan.begin(), scan.end(), is_there) ? 1 : 0;
    gate_m += config_.gate_growth_m;
  }
  return count;
}

}  // namespace ssjs
