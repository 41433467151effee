/// Point targets (piles, posts) in the hits of a forward-looking sonar. docs/math/sonar_points.md (F-1..F-4).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

/// One image of a forward-looking sonar after its own threshold: range (m, positive) and bearing (rad, 0 ahead, anticlockwise positive in
/// the sensor frame) of every strong return, in any order.
struct SonarHits {
  std::vector<Eigen::Vector2d> range_bearing;
};

struct SonarPointConfig {
  double link_range_m = 0.45;
  double link_bearing_rad = 0.0262;
  double link_arc_m = 0.6;
  int min_hits = 3;
  double max_depth_m = 1.0;
  double max_width_m = 2.5;
  double max_width_rad = 0.0873;
  double centre_sigma_m = 0.15;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("link_range_m", link_range_m, Rule::positive(), "hits of one object differ in range by less than this");
    v.field("link_bearing_rad", link_bearing_rad, Rule::positive(), "... and in bearing by less than this, or");
    v.field("link_arc_m", link_arc_m, Rule::positive(), "... by less than this along the arc, whichever is wider");
    v.field("min_hits", min_hits, Rule::at_least(1), "a point target has at least so many hits");
    v.field("max_depth_m", max_depth_m, Rule::positive(), "objects deeper in range are walls or hulls, not points");
    v.field("max_width_m", max_width_m, Rule::positive(), "objects wider than this are no points ...");
    v.field("max_width_rad", max_width_rad, Rule::positive(), "... nor are objects wider than this angle, beyond 1.2 m");
    v.field("centre_sigma_m", centre_sigma_m, Rule::not_negative(), "how far the centre of the hits may lie beside the target's");
  }
};

struct SonarPoint {
  Eigen::Vector2d range_bearing;  ///< m, rad: mean of the hits
  Eigen::Matrix2d covariance;     ///< of that mean by the spread of the hits, and of the target in it; without the sensor's own noise
  int hits = 0;
  double depth_m = 0.0;  ///< extent in range
  double width_m = 0.0;  ///< extent along the arc
};

/// In the order of range, then of bearing. Throws InvalidArgument on hits that are not finite or have no positive range.
[[nodiscard]] std::vector<SonarPoint> detect_sonar_points(const SonarHits& image, const SonarPointConfig& config);

}  // namespace ssjs
