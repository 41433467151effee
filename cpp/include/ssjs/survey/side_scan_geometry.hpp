/// From a sample of a ping to a point in metres with its covariance. Thesis 5.1.3, docs/math/side_scan.md (SS-2) to (SS-9)
///
/// Body frame: x forward, y starboard, z down, origin at the vehicle's reference point. Levelled frame: the same origin and heading, z
/// upright. The seabed is a plane, `altitude_m` straight below the sonar. What stands on it echoes earlier than the seabed below it
/// and is placed too near by about height * altitude / ground range.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/sonar_side.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"

namespace ssjs {

/// What is measured, as it enters the geometry.
struct SideScanEcho {
  SonarSide side = SonarSide::kStarboard;
  double slant_range_m = 0.0;
  double altitude_m = 0.0;
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
};

struct SideScanGeometryConfig {
  double sonar_x_m = 0.0;
  double sonar_y_m = 0.0;
  double sonar_z_m = 0.0;
  double slope_forward = 0.0;
  double slope_starboard = 0.0;
  double sample_m = 0.06;
  double range_sigma_m = 0.1;
  double altitude_sigma_m = 0.1;
  double roll_sigma_rad = 0.0087;
  double pitch_sigma_rad = 0.0087;
  double slope_sigma = 0.02;
  double beam_width_rad = 0.007;
  double time_sigma_s = 0.05;
  double speed_m_s = 1.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("sonar_x_m", sonar_x_m, Rule::any(), "where the transducers are on the vehicle, forward");
    v.field("sonar_y_m", sonar_y_m, Rule::any(), "to starboard; port ones at minus this");
    v.field("sonar_z_m", sonar_z_m, Rule::any(), "down");
    v.field("slope_forward", slope_forward, Rule::closed(-1, 1), "metres by which the seabed falls for a metre ahead");
    v.field("slope_starboard", slope_starboard, Rule::closed(-1, 1), "and for a metre to starboard");
    v.field("sample_m", sample_m, Rule::positive(), "slant range between samples, or the pixel that was measured");
    v.field("range_sigma_m", range_sigma_m, Rule::not_negative(),
            "of the slant range besides the sample's size: where on the object, sound speed");
    v.field("altitude_sigma_m", altitude_sigma_m, Rule::not_negative(), "of the altitude");
    v.field("roll_sigma_rad", roll_sigma_rad, Rule::not_negative(), "of the roll");
    v.field("pitch_sigma_rad", pitch_sigma_rad, Rule::not_negative(), "of the pitch");
    v.field("slope_sigma", slope_sigma, Rule::not_negative(), "of both slopes: how far the seabed is from the plane");
    v.field("beam_width_rad", beam_width_rad, Rule::not_negative(), "along track, two-way, at half power");
    v.field("time_sigma_s", time_sigma_s, Rule::not_negative(), "between the clocks of sonar and navigation, and half a ping");
    v.field("speed_m_s", speed_m_s, Rule::not_negative(), "with which timing becomes a distance along track");
  }
};

/// A point with the covariance of what was measured; in the levelled frame without that of the heading.
struct SideScanPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Slant range of a sample, which may be a fraction. (SS-2) Throws InvalidArgument on a sound speed that is not known.
[[nodiscard]] double slant_range_m(const SideScanPing& ping, const SideScanChannel& channel, double sample);
/// Which sample that is. Its inverse.
[[nodiscard]] double sample_at_slant_range(const SideScanPing& ping, const SideScanChannel& channel, double slant_range_m);

/// Shortest slant range to a flat seabed in the fan, which leans by the pitch: altitude / cos(pitch). An unknown pitch is none. (SS-13)
[[nodiscard]] double first_return_m(const SideScanPing& ping);
/// Its inverse: the altitude of a sonar that hears the seabed first at this range.
[[nodiscard]] double altitude_of_first_return_m(const SideScanPing& ping, double first_return_m);

/// Horizontal distance on that side from the sonar to where it hears the seabed; none in the water column. (SS-5)
[[nodiscard]] std::optional<double> ground_range_on_slope_m(const SideScanEcho& echo, const SideScanGeometryConfig& config);

/// Inputs of body_point and levelled_point, in the order of the columns of their Jacobians.
enum SideScanInput { kSlantRange, kAltitude, kRoll, kPitch, kSlopeForward, kSlopeStarboard, kAlongTrack, kSideScanInputs };
using SideScanJacobian = Eigen::Matrix<double, 3, kSideScanInputs>;

struct SideScanSolution {
  Eigen::Vector3d position_m;
  SideScanJacobian jacobian;
};

/// Where the fan meets the seabed; none in the water column. (SS-3) to (SS-7)
[[nodiscard]] std::optional<SideScanSolution> solve_in_body(const SideScanEcho& echo, const SideScanGeometryConfig& config);
[[nodiscard]] std::optional<SideScanSolution> solve_levelled(const SideScanEcho& echo, const SideScanGeometryConfig& config);

/// The same with the covariance J diag(sigma^2) J'. (SS-8), (SS-9)
[[nodiscard]] std::optional<SideScanPoint> body_point(const SideScanEcho& echo, const SideScanGeometryConfig& config);
[[nodiscard]] std::optional<SideScanPoint> levelled_point(const SideScanEcho& echo, const SideScanGeometryConfig& config);

}  // namespace ssjs
