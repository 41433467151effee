/// What an event must be before it may touch the estimate.
#pragma once

#include <optional>

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace ssjs {

/// Finite values, times that do not decrease, positive ranges, positive definite observation covariances, odometry of the configured
/// kind. Throws InvalidArgument or NotPositiveDefinite naming the time.
void check_event(const Event& event, std::optional<double> last_time_s, VehicleKind kind);

}  // namespace ssjs
