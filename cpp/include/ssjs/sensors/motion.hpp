/// What every motion model answers: the predicted pose with its Jacobian and additive process noise.
#pragma once

#include <Eigen/Core>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

struct MotionPrediction {
  Se2 submap_T_vehicle;  ///< after the step
  Eigen::Matrix3d F;     ///< d(new pose)/d(old pose), additive coordinates
  Eigen::Matrix3d Q;     ///< covariance added by this step, additive coordinates, submap frame
};

}  // namespace ssjs
