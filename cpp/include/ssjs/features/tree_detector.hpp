/// Trunk centres from a planar laser scan. Thesis 4.2.1, docs/math/tree_detector.md.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/base/config_field.hpp"

namespace ssjs {

/// One sweep: beam i points at first_angle_rad + i * step_rad in the sensor frame (0 ahead, anticlockwise positive).
/// The step is negative for a sensor that sweeps clockwise. NaN, infinite, zero and negative ranges mean no return.
struct LaserScan {
  Eigen::VectorXd range_m;
  double first_angle_rad = 0.0;
  double step_rad = 0.0;
};

struct TreeDetectorConfig {
  double min_range_m = 3.0;
  double max_range_m = 40.0;
  double no_return_m = 80.0;
  int masked_beams = 0;
  double max_range_jump_m = 1.5;
  int max_missing_beams = 3;
  int min_beams = 1;
  double min_diameter_m = 0.0;
  double max_diameter_m = 1.2;
  double max_slant = 1.0 / 3.0;
  double min_clearance_m = 3.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("min_range_m", min_range_m, Rule::not_negative(), "trunks nearer than this are ignored");
    v.field("max_range_m", max_range_m, Rule::positive(), "trunks farther than this are ignored");
    v.field("no_return_m", no_return_m, Rule::positive(), "ranges at or beyond it mean that nothing was hit");
    v.field("masked_beams", masked_beams, Rule::not_negative(), "number of first beams that see the vehicle itself");
    v.field("max_range_jump_m", max_range_jump_m, Rule::positive(), "neighbouring beams on one object differ by at most this");
    v.field("max_missing_beams", max_missing_beams, Rule::not_negative(), "so many beams in a row without return do not end an object");
    v.field("min_beams", min_beams, Rule::at_least(1), "a trunk is hit by at least so many beams");
    v.field("min_diameter_m", min_diameter_m, Rule::not_negative(), "thinner objects are not trunks");
    v.field("max_diameter_m", max_diameter_m, Rule::positive(), "wider objects are not trunks");
    v.field("max_slant", max_slant, Rule::not_negative(), "the two boundary beams of a trunk differ by at most this part of its diameter");
    v.field("min_clearance_m", min_clearance_m, Rule::not_negative(), "objects closer together than this are bushes or walls, not trunks");
  }
};

/// A trunk in the sensor frame.
struct Trunk {
  double range_m = 0.0;      ///< to the centre
  double bearing_rad = 0.0;  ///< in [-pi, pi)
  double diameter_m = 0.0;
};

/// In the order of the beams. Neighbouring returns form objects; an object is a trunk when both its boundary beams are tangents
/// of it (no nearer object next to them, not at the border of the sweep), when it is round rather than slanted, neither too
/// thin nor too wide, and stands clear of every other object. A trunk that lies across the seam of a full turn is not found.
/// Throws InvalidArgument on a configuration that contradicts itself, or a scan without finite angles.
[[nodiscard]] std::vector<Trunk> detect_trunks(const LaserScan& scan, const TreeDetectorConfig& config);

}  // namespace ssjs
