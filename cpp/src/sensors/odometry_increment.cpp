#include "ssjs/sensors/odometry_increment.hpp"

namespace ssjs {

MotionPrediction predict_increment(const Se2& submap_T_vehicle, const OdometryIncrement& increment) {
  const Eigen::Matrix3d J2 = compose_jacobian_right(submap_T_vehicle);
  return {submap_T_vehicle * increment.old_T_new.mean,  // (M-8)
          compose_jacobian_left(submap_T_vehicle, increment.old_T_new.mean), J2 * increment.old_T_new.covariance * J2.transpose()};
}

}  // namespace ssjs
