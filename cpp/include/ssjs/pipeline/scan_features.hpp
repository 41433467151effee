/// From what a sensor delivers to the features that association may use.
#pragma once

#include <optional>

#include "ssjs/features/event.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/features/sonar_point_detector.hpp"
#include "ssjs/features/tree_detector.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {

/// Those within the configured ranges, their bearings corrected by the mounting yaw.
[[nodiscard]] Features usable_features(const Features& scan, const RangeBearingConfig& sensor);

/// Trunks of a laser scan as usable features with the configured noise.
[[nodiscard]] Features detect_features(const LaserScan& scan, const TreeDetectorConfig& trees, const RangeBearingConfig& sensor);

/// Point targets of a sonar image as usable features: the configured noise and the covariance of each centre.
[[nodiscard]] Features detect_features(const SonarHits& image, const SonarPointConfig& points, const RangeBearingConfig& sensor);

/// The usable features of an observation of any kind; nothing for odometry.
[[nodiscard]] std::optional<Features> observed_features(const Event& event, const TreeDetectorConfig& trees, const SonarPointConfig& points,
                                                        const RangeBearingConfig& sensor);

}  // namespace ssjs
