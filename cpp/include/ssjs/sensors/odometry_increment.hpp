/// A measured relative pose between two instants. docs/math/sensors.md (M-8).
#pragma once

#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// old_T_new with its covariance in the frame of the old pose.
struct OdometryIncrement {
  GaussianSe2 old_T_new;
};

[[nodiscard]] MotionPrediction predict_increment(const Se2& submap_T_vehicle, const OdometryIncrement& increment);

}  // namespace ssjs
