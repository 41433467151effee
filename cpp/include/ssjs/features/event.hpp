/// One stamped record of a log, of any kind.
#pragma once

#include <variant>

#include "ssjs/features/feature.hpp"
#include "ssjs/features/sonar_point_detector.hpp"
#include "ssjs/features/tree_detector.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/odometry_increment.hpp"
#include "ssjs/sensors/unicycle.hpp"

namespace ssjs {

/// Velocity controls hold from their time until the next odometry event; an increment leads from the previous one to its time.
struct Event {
  double time_s = 0.0;
  std::variant<AckermanControl, VelocityControl, OdometryIncrement, Features, LaserScan, SonarHits> record;
};

}  // namespace ssjs
