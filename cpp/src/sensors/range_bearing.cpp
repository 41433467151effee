#include "ssjs/sensors/range_bearing.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {

RangeBearingPrediction predict_range_bearing(const Se2& submap_T_vehicle, const Eigen::Vector2d& submap_p_landmark) {
  const double dx = submap_p_landmark.x() - submap_T_vehicle.x;
  const double dy = submap_p_landmark.y() - submap_T_vehicle.y;
  const double range = std::sqrt(dx * dx + dy * dy);
  constexpr double kAtSensorMetres = 1e-9;
  if (!(range >= kAtSensorMetres)) {
    throw InvalidArgument("predict_range_bearing range", range, "the landmark must be at least 1e-9 m away: nearer it has no bearing");
  }
  const double x_over_r = dx / range;
  const double y_over_r = dy / range;
  const double x_over_r2 = x_over_r / range;
  const double y_over_r2 = y_over_r / range;

  RangeBearingPrediction prediction;
  prediction.range_bearing << range, angle_difference(std::atan2(dy, dx), submap_T_vehicle.heading);  // (M-9)
  prediction.H_landmark << x_over_r, y_over_r, -y_over_r2, x_over_r2;                                 // (M-10)
  prediction.H_vehicle << -x_over_r, -y_over_r, 0.0, y_over_r2, -x_over_r2, -1.0;
  return prediction;
}

LandmarkFromRangeBearing landmark_from_range_bearing(const Se2& submap_T_vehicle, const Eigen::Vector2d& range_bearing) {
  const double range = range_bearing.x();
  const double direction = submap_T_vehicle.heading + range_bearing.y();
  if (!(range >= 0.0) || !std::isfinite(range)) {
    throw InvalidArgument("landmark_from_range_bearing range", range, "must be zero or positive, and finite");
  }
  const double c = std::cos(direction);
  const double s = std::sin(direction);

  LandmarkFromRangeBearing landmark;
  landmark.submap_p_landmark << submap_T_vehicle.x + range * c, submap_T_vehicle.y + range * s;  // (M-11)
  landmark.J_vehicle << 1.0, 0.0, -range * s, 0.0, 1.0, range * c;                               // (M-12)
  landmark.J_measurement << c, -range * s, s, range * c;
  return landmark;
}

}  // namespace ssjs
