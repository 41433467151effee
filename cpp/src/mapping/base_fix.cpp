#include "ssjs/mapping/base_fix.hpp"

#include <Eigen/Geometry>

namespace ssjs {

void FixKeeper::keep(double time_s, const PositionFix& fix, const VehicleVector& vehicle) {
  if (!interval_s_) return;
  const bool too_soon = used_s_ && time_s - *used_s_ < *interval_s_;
  if (too_soon && !fix.set_pose) return;
  if (kept_ && kept_->fix.set_pose && !fix.set_pose) return;
  kept_ = Kept{time_s, fix, vehicle.segment<2>(VehicleLayout::kPosition)};
}

std::optional<BaseFix> FixKeeper::take(double time_s, const VehicleVector& vehicle, const VehicleMatrix& covariance) {
  if (!kept_) return std::nullopt;
  BaseFix base{kept_->time_s, {}, kept_->fix};  // (P-30)
  const Eigen::Vector2d back = kept_->map_p_vehicle - vehicle.segment<2>(VehicleLayout::kPosition);
  base.base_p_vehicle = Eigen::Rotation2Dd(-vehicle(VehicleLayout::kAttitude + 2)) * back;
  const double dt = time_s - kept_->time_s;
  const double speed_variance = covariance.block<2, 2>(VehicleLayout::kVelocity, VehicleLayout::kVelocity).trace();
  base.fix.covariance.diagonal().array() += dt * dt * speed_variance;
  used_s_ = kept_->time_s;
  kept_.reset();
  return base;
}

}  // namespace ssjs
