/// Range and bearing of a point landmark. Thesis 3.19, 3.20 corrected; docs/math/sensors.md (M-9..M-12).
#pragma once

#include <Eigen/Core>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/se2.hpp"

namespace ssjs {

struct RangeBearingConfig {
  double range_sigma_m = 0.1;
  double bearing_sigma_rad = 0.0174532925199433;
  double bearing_offset_rad = 0.0;  ///< added to every measured bearing (mounting yaw of the sensor)
  double min_range_m = 0.0;
  double max_range_m = 1000.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("range_sigma_m", range_sigma_m, Rule::positive(), "range noise, where the log gives none");
    v.field("bearing_sigma_rad", bearing_sigma_rad, Rule::positive(), "bearing noise, where the log gives none");
    v.field("bearing_offset_rad", bearing_offset_rad, Rule::closed(-4.0, 4.0), "added to every measured bearing");
    v.field("min_range_m", min_range_m, Rule::not_negative(), "nearer observations are ignored");
    v.field("max_range_m", max_range_m, Rule::positive(), "farther observations are ignored");
  }
};

struct RangeBearingPrediction {
  Eigen::Vector2d range_bearing;  ///< h, m and rad in [-pi, pi)
  Eigen::Matrix<double, 2, 3> H_vehicle;
  Eigen::Matrix2d H_landmark;
};

/// Prediction for a landmark in the same frame as the vehicle pose. A landmark at the sensor itself (< 1e-9 m) throws InvalidArgument.
[[nodiscard]] RangeBearingPrediction predict_range_bearing(const Se2& submap_T_vehicle, const Eigen::Vector2d& submap_p_landmark);

struct LandmarkFromRangeBearing {
  Eigen::Vector2d submap_p_landmark;
  Eigen::Matrix<double, 2, 3> J_vehicle;
  Eigen::Matrix2d J_measurement;  ///< d(landmark)/d(range, bearing)
};

/// The inverse of predict_range_bearing in its second argument.
[[nodiscard]] LandmarkFromRangeBearing landmark_from_range_bearing(const Se2& submap_T_vehicle, const Eigen::Vector2d& range_bearing);

}  // namespace ssjs
