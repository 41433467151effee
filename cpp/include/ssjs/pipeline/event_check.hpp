/// What an event must be before it may touch the estimate.
#pragma once

#include <optional>

#include "ssjs/features/event.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace ssjs {

/// Finite values, times that do not decrease, positive ranges, numbers that are covariances, odometry of the configured kind that its
/// model can drive. Throws InvalidArgument or NotPositiveDefinite naming the time.
void check_event(const Event& event, std::optional<double> last_time_s, const VehicleConfig& vehicle);

}  // namespace ssjs
