#include "ssjs/sensors/odometry_increment.hpp"

namespace ssjs {

OdometryIncrement calibrated(OdometryIncrement increment, const IncrementsConfig& config) {
  increment.old_T_new.mean.x *= config.distance_scale;
  increment.old_T_new.mean.y *= config.distance_scale;
  return increment;
}

MotionPrediction predict_increment(const Se2& submap_T_vehicle, const OdometryIncrement& increment) {
  const auto& [mean, covariance] = increment.old_T_new;
  const Eigen::Matrix2d R = submap_T_vehicle.rotation();
  const Eigen::Vector2d moved = R * mean.translation();
  MotionPrediction prediction;  // (M-8)
  prediction.submap_T_vehicle = {submap_T_vehicle.x + moved.x(), submap_T_vehicle.y + moved.y(),
                                 wrap_angle(submap_T_vehicle.heading + mean.heading)};
  prediction.F << 1.0, 0.0, -moved.y(),  //
      0.0, 1.0, moved.x(),               //
      0.0, 0.0, 1.0;
  prediction.Q = turned(R, covariance);
  return prediction;
}

}  // namespace ssjs
