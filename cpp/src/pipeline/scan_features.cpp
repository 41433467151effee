#include "ssjs/pipeline/scan_features.hpp"

#include "ssjs/base/angle.hpp"

namespace ssjs {

Features usable_features(const Features& scan, const RangeBearingConfig& sensor) {
  Features kept;
  kept.reserve(scan.size());
  for (const Feature& feature : scan) {
    if (feature.range() < sensor.min_range_m || feature.range() > sensor.max_range_m) continue;
    kept.push_back(feature);
    kept.back().range_bearing.y() = wrap_angle(feature.bearing() + sensor.bearing_offset_rad);
  }
  return kept;
}

Features detect_features(const LaserScan& scan, const TreeDetectorConfig& trees, const RangeBearingConfig& sensor) {
  const Eigen::Vector2d variance(sensor.range_sigma_m * sensor.range_sigma_m, sensor.bearing_sigma_rad * sensor.bearing_sigma_rad);
  Features trunks;
  for (const Trunk& trunk : detect_trunks(scan, trees)) {
    trunks.push_back({{trunk.range_m, trunk.bearing_rad}, variance.asDiagonal(), std::nullopt});
  }
  return usable_features(trunks, sensor);
}

Features detect_features(const SonarHits& image, const SonarPointConfig& points, const RangeBearingConfig& sensor) {
  const Eigen::Vector2d variance(sensor.range_sigma_m * sensor.range_sigma_m, sensor.bearing_sigma_rad * sensor.bearing_sigma_rad);
  Features targets;
  for (const SonarPoint& point : detect_sonar_points(image, points)) {
    Eigen::Matrix2d R = point.covariance;
    R.diagonal() += variance;
    targets.push_back({point.range_bearing, R, std::nullopt});
  }
  return usable_features(targets, sensor);
}

std::optional<Features> observed_features(const Event& event, const TreeDetectorConfig& trees, const SonarPointConfig& points,
                                          const RangeBearingConfig& sensor) {
  if (const auto* scan = std::get_if<LaserScan>(&event.record)) return detect_features(*scan, trees, sensor);
  if (const auto* image = std::get_if<SonarHits>(&event.record)) return detect_features(*image, points, sensor);
  if (const auto* features = std::get_if<Features>(&event.record)) return usable_features(*features, sensor);
  return std::nullopt;
}

}  // namespace ssjs
