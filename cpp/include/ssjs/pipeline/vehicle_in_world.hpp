/// From the map that is being built to the world.
#pragma once

#include "ssjs/filter/levelled_filter.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/port_estimate.hpp"
#include "ssjs/sensors/position_fix.hpp"

namespace ssjs {

/// `vehicle` of a levelled map whose base stands at global_T_base. The base moves x, y and heading; depth, roll and pitch are absolute in
/// the map already. Additive covariance, that of the pose in the map being the top left 6 x 6 of `covariance`.
[[nodiscard]] SurveyStep vehicle_in_world(const GaussianSe2& global_T_base, const VehicleVector& vehicle, const Matrix6d& covariance,
                                          double time_s);

/// The first base before its map is closed: it heads where the compass says that it does, less `north_offset_rad`.
[[nodiscard]] GaussianSe2 base_facing_north(const LevelledFilter& filter, double north_offset_rad, double north_offset_sigma_rad);

/// The first base before its map is closed, where it came with a fix: `base` moved there, its heading, where it was taken for exact, known
/// to this.
[[nodiscard]] GaussianSe2 base_at_fix(GaussianSe2 base, const PositionFix& fix, double heading_sigma_rad);

}  // namespace ssjs
