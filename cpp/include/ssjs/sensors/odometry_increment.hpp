/// A measured relative pose between two instants. docs/math/sensors.md (M-8).
#pragma once

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/sensors/motion.hpp"

namespace ssjs {

/// old_T_new with its covariance in the frame of the old pose.
struct OdometryIncrement {
  GaussianSe2 old_T_new;
};

struct IncrementsConfig {
  double distance_scale = 1.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("distance_scale", distance_scale, Rule::positive(), "measured distances are multiplied by it, headings and noise are not");
  }
};

/// The increment with its distances calibrated.
[[nodiscard]] OdometryIncrement calibrated(OdometryIncrement increment, const IncrementsConfig& config);

[[nodiscard]] MotionPrediction predict_increment(const Se2& submap_T_vehicle, const OdometryIncrement& increment);

}  // namespace ssjs
