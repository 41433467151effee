/// A survey by an underwater vehicle with side-scan sonar: what its navigation sensors and a perfect detector say, and the truth.
/// docs/math/auv.md (A-20..A-23).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/features/navigation_tick.hpp"
#include "ssjs/sensors/constant_velocity.hpp"

namespace ssjs {

/// Points on the seabed and the lines over it, m, x north, y east, z depth.
struct SurveyWorld {
  Eigen::Matrix3Xd landmarks_m;            ///< 3xn
  std::vector<std::int64_t> ids;           ///< n
  std::vector<Eigen::Vector2d> waypoints;  ///< the vehicle starts at the first, heading to the second
  std::vector<std::optional<int>> dives;   ///< of the leg after each waypoint: 0 the first; none at the surface. Empty: one dive
};

/// `landmarks` points spread evenly over a rectangle about the lines.
struct SurveyWorldConfig {
  int lines = 5;
  double line_length_m = 120.0;
  double line_spacing_m = 20.0;
  int cross_lines = 3;
  double cross_margin_m = 10.0;  ///< cross lines begin and end so far outside the lines
  bool surface_start = false;    ///< the log begins at the surface, run_in_m before the vehicle dives
  int dives = 1;                 ///< the lines and cross lines are driven in each; from one to the next at the surface
  double run_in_m = 60.0;        ///< the vehicle dives again so far before the first line
  int landmarks = 60;
  double landmark_margin_m = 25.0;  ///< landmarks lie up to so far outside the lines
  double seabed_depth_m = 16.0;
  double landmark_height_sigma_m = 0.2;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("lines", lines, Rule::at_least(1), "parallel lines, to and fro");
    v.field("line_length_m", line_length_m, Rule::positive(), "length of a line");
    v.field("line_spacing_m", line_spacing_m, Rule::positive(), "between two lines");
    v.field("cross_lines", cross_lines, Rule::not_negative(), "lines across them, afterwards");
    v.field("cross_margin_m", cross_margin_m, Rule::not_negative(), "cross lines begin and end so far outside the lines");
    v.field("surface_start", surface_start, "the mission begins at the surface, run_in_m before the vehicle dives");
    v.field("dives", dives, Rule::at_least(1), "times that all lines are driven; from one to the next at the surface");
    v.field("run_in_m", run_in_m, Rule::positive(), "the vehicle dives again so far before the first line");
    v.field("landmarks", landmarks, Rule::not_negative(), "points on the seabed");
    v.field("landmark_margin_m", landmark_margin_m, Rule::not_negative(), "landmarks lie up to so far outside the lines");
    v.field("seabed_depth_m", seabed_depth_m, Rule::positive(), "mean depth of the seabed");
    v.field("landmark_height_sigma_m", landmark_height_sigma_m, Rule::not_negative(), "landmarks above and below the mean seabed");
  }
};

/// The first line starts at the origin and heads north. The seed places the landmarks.
[[nodiscard]] SurveyWorld survey_world(const SurveyWorldConfig& config, std::uint64_t seed);

/// A time during which a sensor gives nothing.
struct Outage {
  double begin_s = 0.0;
  double end_s = 0.0;
};

/// Noises are those of the sensor configurations: a filter with the same ones has the right model.
struct AuvSimulationConfig {
  ConstantVelocityConfig motion;  ///< noise of the gyro; walks of velocity, seabed and compass offset
  AttitudeConfig attitude;
  CompassConfig compass;
  DepthConfig depth;
  AltitudeConfig altitude;
  VelocityLogConfig velocity_log;
  SideScanConfig side_scan;
  double step_s = 0.1;         ///< gyro and truth
  int steps_per_attitude = 1;  ///< roll, pitch
  int steps_per_compass = 1;
  int steps_per_depth = 1;
  int steps_per_velocity = 2;
  int steps_per_altitude = 2;
  int phase_steps = 0;  ///< altitude, depth and compass come so many steps after the velocity log
  double speed_m_s = 1.5;
  double depth_m = 12.0;
  double dive_step_m = 0.0;                ///< each dive of the survey is so much deeper than the one before
  double surface_depth_m = 0.5;            ///< between two dives
  double depth_gain_rad_m = 0.05;          ///< of the elevators: pitch aimed at for a metre off its depth
  std::optional<double> duration_s;        ///< the mission ends after so long, wherever the vehicle is
  double velocity_time_constant_s = 20.0;  ///< the velocity's walk is pulled back to the speed within about this
  double seabed_time_constant_s = 60.0;    ///< the same for the seabed's depth
  double compass_offset_rad = 0.7;         ///< at the start; walks with motion.compass_walk_rad_sqrt_s
  double compass_deviation_rad = 0.0;      ///< amplitude of an error that goes with the sine of the heading
  Eigen::Vector3d gyro_bias_rad_s = Eigen::Vector3d::Zero();
  double velocity_log_scale = 0.0;       ///< readings are 1 + this times the velocity
  double velocity_log_yaw_rad = 0.0;     ///< yaw of the instrument beyond its mounting angle
  double velocity_loss_fraction = 0.05;  ///< single samples of the velocity log without bottom lock
  double velocity_gap_s = 5.0;           ///< now and then it loses the bottom for so long ...
  double velocity_gap_every_s = 120.0;   ///< ... after exponential times of this mean
  std::vector<Outage> velocity_outages;  ///< and at these times
  double sample_loss_fraction = 0.0;     ///< of attitude, compass, depth and altitude samples, each by itself
  double tide_m = 0.0;                   ///< depth readings gain a sine of this amplitude, 0 at the start; the altitude does not
  double tide_period_s = 44712.0;        ///< 12.42 h
  std::optional<double> fix_interval_s;  ///< between position fixes, which there are at the surface alone
  double fix_sigma_m = 1.5;              ///< of each coordinate, white
  double fix_depth_m = 1.0;              ///< deeper than this there is none
  double mirrored_fraction = 0.0;        ///< of the sightings come a second time from the other side, as cross talk does
  double clutter_per_s = 0.0;            ///< sightings of nothing, evenly over the swath; identities from kFirstClutterId on
  double min_across_m = 3.0;             ///< the swath on each side
  double max_across_m = 30.0;
  double max_turn_rate_rad_s = 0.0349066;        ///< no side-scan while the vehicle turns faster: images are smeared
  double turn_rate_rad_s = 0.13962634015954636;  ///< of the vehicle in its turns, at most
  double lookahead_m = 12.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("motion", motion, "noise of the gyro; walks of velocity, seabed and compass offset");
    v.section("attitude", attitude, "roll and pitch");
    v.section("compass", compass, "heading");
    v.section("depth", depth, "pressure depth");
    v.section("altitude", altitude, "height above the seabed");
    v.section("velocity_log", velocity_log, "Doppler velocity log");
    v.section("side_scan", side_scan, "sightings");
    v.field("step_s", step_s, Rule::positive(), "time between two gyro samples");
    v.field("steps_per_attitude", steps_per_attitude, Rule::at_least(1), "a sample every so many steps");
    v.field("steps_per_compass", steps_per_compass, Rule::at_least(1), "a sample every so many steps");
    v.field("steps_per_depth", steps_per_depth, Rule::at_least(1), "a sample every so many steps");
    v.field("steps_per_velocity", steps_per_velocity, Rule::at_least(1), "a sample every so many steps");
    v.field("steps_per_altitude", steps_per_altitude, Rule::at_least(1), "a sample every so many steps");
    v.field("phase_steps", phase_steps, Rule::not_negative(), "altitude, depth and compass come so many steps after the velocity log");
    v.field("speed_m_s", speed_m_s, Rule::positive(), "through the survey");
    v.field("depth_m", depth_m, Rule::not_negative(), "of the vehicle in its first dive");
    v.field("dive_step_m", dive_step_m, Rule::any(), "each dive is so much deeper than the one before");
    v.field("surface_depth_m", surface_depth_m, Rule::not_negative(), "of the vehicle between two dives");
    v.field("depth_gain_rad_m", depth_gain_rad_m, Rule::positive(), "pitch that the vehicle aims at for a metre off its depth");
    v.field("duration_s", duration_s, Rule::positive(), "the mission ends after so long, wherever the vehicle is");
    v.field("velocity_time_constant_s", velocity_time_constant_s, Rule::positive(), "the velocity returns to the speed within about this");
    v.field("seabed_time_constant_s", seabed_time_constant_s, Rule::positive(), "the seabed returns to its mean depth within about this");
    v.field("compass_offset_rad", compass_offset_rad, Rule::any(), "reading minus heading at the start");
    v.field("compass_deviation_rad", compass_deviation_rad, Rule::not_negative(), "amplitude of an error with the sine of the heading");
    v.field("velocity_log_scale", velocity_log_scale, Rule::open(-1, 1), "scale error of the velocity log");
    v.field("velocity_log_yaw_rad", velocity_log_yaw_rad, Rule::closed(-1, 1), "yaw of the velocity log beyond its mounting angle");
    v.field("velocity_loss_fraction", velocity_loss_fraction, Rule{0, 1, false, true}, "samples of the velocity log without bottom lock");
    v.field("velocity_gap_s", velocity_gap_s, Rule::not_negative(), "now and then the velocity log loses the bottom for so long");
    v.field("velocity_gap_every_s", velocity_gap_every_s, Rule::positive(), "mean time between two such gaps");
    v.field("sample_loss_fraction", sample_loss_fraction, Rule{0, 1, false, true}, "lost samples of the other sensors");
    v.field("tide_m", tide_m, Rule::not_negative(), "depth readings gain a sine of this amplitude");
    v.field("tide_period_s", tide_period_s, Rule::positive(), "and this period");
    v.field("fix_interval_s", fix_interval_s, Rule::positive(),
            "between position fixes, which there are at the surface alone; none: no fix");
    v.field("fix_sigma_m", fix_sigma_m, Rule::positive(), "noise of each coordinate of a fix, white");
    v.field("fix_depth_m", fix_depth_m, Rule::not_negative(), "a deeper vehicle has no fix");
    v.field("mirrored_fraction", mirrored_fraction, Rule::closed(0, 1), "of the sightings come a second time from the other side");
    v.field("clutter_per_s", clutter_per_s, Rule::not_negative(), "sightings of nothing, evenly over the swath");
    v.field("min_across_m", min_across_m, Rule::not_negative(), "nearest horizontal distance of the swath");
    v.field("max_across_m", max_across_m, Rule::positive(), "farthest horizontal distance of the swath");
    v.field("max_turn_rate_rad_s", max_turn_rate_rad_s, Rule::positive(), "no side-scan while the vehicle turns faster");
    v.field("turn_rate_rad_s", turn_rate_rad_s, Rule::positive(), "of the vehicle in its turns, at most");
    v.field("lookahead_m", lookahead_m, Rule::positive(), "the vehicle aims at the point of the path so far ahead");
  }
};

/// The truth at one tick; world = the frame of the SurveyWorld.
struct AuvTruth {
  double time_s = 0.0;
  Se3 world_T_vehicle;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< body axes
  Eigen::Vector3d rates_rad_s = Eigen::Vector3d::Zero();   ///< body axes, from this tick to the next
  double seabed_m = 0.0;                                   ///< depth under the vehicle
  double compass_offset_rad = 0.0;                         ///< reading without noise minus heading in the world
};

/// Mirrored echoes and clutter are of nothing that is seen again: each has an identity of its own.
inline constexpr std::int64_t kFirstClutterId = 1'000'000;

struct SimulatedSurvey {
  std::vector<NavigationTick> ticks;
  std::vector<AuvTruth> truth;  ///< of each tick
  SurveyWorld world;
};

/// Depth of the seabed at a point (north, east), m.
using SeabedDepth = std::function<double(const Eigen::Vector2d&)>;

/// Drives the lines once. Streams of the seed: "gyro", "attitude", "compass", "depth", "altitude", "velocity", "side scan" (measurements),
/// "fix", "mirrored", "clutter" (sightings of nothing), "velocity walk", "seabed walk", "compass walk" (truth), "velocity loss", "sample
/// loss" (which samples are missing). A `seabed` is the one that the altitude is measured over; without it the depth under the vehicle
/// walks. Throws InvalidArgument for a configuration out of its rules or a path that cannot be driven.
[[nodiscard]] SimulatedSurvey simulate_survey(const SurveyWorld& world, const AuvSimulationConfig& config, std::uint64_t seed,
                                              const SeabedDepth& seabed = {});

}  // namespace ssjs
