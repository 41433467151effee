#include "ssjs/pipeline/vehicle_in_world.hpp"

#include <array>

#include <vector>

#include "ssjs/base/angle.hpp"

namespace ssjs {

SurveyStep vehicle_in_world(const GaussianSe2& global_T_base, const VehicleVector& vehicle, const Matrix6d& covariance, double time_s) {
  constexpr std::array<Eigen::Index, 3> kPlanar{0, 1, 5};
  const Se2 base_T_vehicle = Se2::from_vector(vehicle(kPlanar));
  const Se2 global = global_T_base.mean * base_T_vehicle;
  Matrix6d J = Matrix6d::Identity();
  J.topLeftCorner<2, 2>() = global_T_base.mean.rotation();
  SurveyStep step;
  step.time_s = time_s;
  step.global_T_vehicle = vehicle.head<6>();
  step.global_T_vehicle(kPlanar) = global.vector();
  step.covariance = J * covariance * J.transpose();
  const Eigen::Matrix3d J_base = compose_jacobian_left(global_T_base.mean, base_T_vehicle);
  step.covariance(kPlanar, kPlanar) += J_base * global_T_base.covariance * J_base.transpose();
  return step;
}

GaussianSe2 base_facing_north(const LevelledFilter& filter, double north_offset_rad, double north_offset_sigma_rad) {
  constexpr Eigen::Index kStart = VehicleLayout::kStartOffset;
  GaussianSe2 base;
  base.mean.heading = wrap_angle(filter.vehicle()(kStart) - north_offset_rad);
  base.covariance(2, 2) = filter.vehicle_covariance()(kStart, kStart) + north_offset_sigma_rad * north_offset_sigma_rad;
  return base;
}

GaussianSe2 base_at_fix(GaussianSe2 base, const PositionFix& fix, double heading_sigma_rad) {
  base.mean.x = fix.world_p_vehicle.x();
  base.mean.y = fix.world_p_vehicle.y();
  base.covariance.topLeftCorner<2, 2>() = fix.covariance;
  if (!(base.covariance(2, 2) > 0.0)) base.covariance(2, 2) = heading_sigma_rad * heading_sigma_rad;
  return base;
}

}  // namespace ssjs
