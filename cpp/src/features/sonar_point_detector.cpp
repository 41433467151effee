#include "ssjs/features/sonar_point_detector.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kWideAngleFrom = 1.2;  // m of arc: near the sonar a thin target fills a wide angle

using Hits = std::vector<Eigen::Vector2d>;

/// Hits by range, then bearing: the order of the answer does not depend on that of the log.
Hits sorted(const SonarHits& image) {
  Hits hits = image.range_bearing;
  for (const Eigen::Vector2d& hit : hits) {
    if (!hit.allFinite()) throw InvalidArgument("sonar hit", "not finite", "remove the hit or mend the log");
    if (!(hit.x() > 0.0)) throw InvalidArgument("sonar hit range", hit.x(), "must be positive");
  }
  std::sort(hits.begin(), hits.end(),
            [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  return hits;
}

bool are_linked(const Eigen::Vector2d& near, const Eigen::Vector2d& far, const SonarPointConfig& config) {
  const double bearing_reach = std::max(config.link_bearing_rad, config.link_arc_m / near.x());
  const double range = (far.x() - near.x()) / config.link_range_m;
  const double bearing = (far.y() - near.y()) / bearing_reach;
  return range * range + bearing * bearing <= 1.0;  // (F-1)
}

/// Index of the object of every hit; the hits must be sorted.
std::vector<int> objects_of(const Hits& hits, const SonarPointConfig& config, int& count) {
  std::vector<int> object(hits.size(), -1);
  std::vector<std::size_t> open;
  count = 0;
  for (std::size_t seed = 0; seed < hits.size(); ++seed) {
    if (object[seed] >= 0) continue;
    object[seed] = count;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      const auto visit = [&](std::size_t j) {
        if (object[j] >= 0 || !are_linked(hits[std::min(i, j)], hits[std::max(i, j)], config)) return;
        object[j] = count;
        open.push_back(j);
      };
      for (std::size_t j = i; j > 0 && hits[i].x() - hits[j - 1].x() <= config.link_range_m; --j) visit(j - 1);
      for (std::size_t j = i + 1; j < hits.size() && hits[j].x() - hits[i].x() <= config.link_range_m; ++j) visit(j);
    }
    ++count;
  }
  return object;
}

SonarPoint point_of(const Hits& hits, const SonarPointConfig& config) {
  const auto n = static_cast<double>(hits.size());
  SonarPoint point;
  point.hits = static_cast<int>(hits.size());
  point.range_bearing = std::accumulate(hits.begin(), hits.end(), Eigen::Vector2d(0.0, 0.0)) / n;
  Eigen::Vector2d low = hits.front();
  Eigen::Vector2d high = hits.front();
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& hit : hits) {
    low = low.cwiseMin(hit);
    high = high.cwiseMax(hit);
    scatter += (hit - point.range_bearing) * (hit - point.range_bearing).transpose();
  }
  const double range = point.range_bearing.x();
  const Eigen::Vector2d centre_sigma(config.centre_sigma_m, config.centre_sigma_m / range);
  point.covariance = scatter / (n * n);
  point.covariance.diagonal() += centre_sigma.cwiseAbs2();  // (F-3)
  point.depth_m = high.x() - low.x();
  point.width_m = range * (high.y() - low.y());
  return point;
}

bool is_point(const SonarPoint& object, const SonarPointConfig& config) {  // (F-2)
  const double widest = std::min(config.max_width_m, std::max(kWideAngleFrom, config.max_width_rad * object.range_bearing.x()));
  return object.hits >= config.min_hits && object.depth_m <= config.max_depth_m && object.width_m <= widest;
}

}  // namespace

std::vector<SonarPoint> detect_sonar_points(const SonarHits& image, const SonarPointConfig& config) {
  throw_if_any(violations(config));
  const Hits hits = sorted(image);
  int count = 0;
  const std::vector<int> object = objects_of(hits, config, count);
  std::vector<Hits> members(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < hits.size(); ++i) members[static_cast<std::size_t>(object[i])].push_back(hits[i]);
  std::vector<SonarPoint> points;
  for (const Hits& of_one : members) {
    const SonarPoint candidate = point_of(of_one, config);
    if (is_point(candidate, config)) points.push_back(candidate);
  }
  std::sort(points.begin(), points.end(), [](const SonarPoint& a, const SonarPoint& b) {
    const Eigen::Vector2d& p = a.range_bearing;
    const Eigen::Vector2d& q = b.range_bearing;
    return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
  });
  return points;
}

}  // namespace ssjs
