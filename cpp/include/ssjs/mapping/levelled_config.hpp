/// How levelled maps of an underwater vehicle are built. docs/math/auv.md (A-15..A-19).
#pragma once

#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/mapping/frame_association.hpp"
#include "ssjs/mapping/scan_association.hpp"
#include "ssjs/mapping/split_policy.hpp"
#include "ssjs/sensors/constant_velocity.hpp"
#include "ssjs/sensors/navigation_sensors.hpp"
#include "ssjs/sensors/pinhole.hpp"
#include "ssjs/sensors/side_scan.hpp"

namespace ssjs {

/// What a map does with its compass.
enum class CompassUse {
  kFilter,        ///< readings correct the heading, the offset is a state (A-7); with a drift of 0 it is one constant
  kMean,          ///< for an uncalibrated compass: kept out of the filter, its mean over the map is handed on (A-19)
  kFirstReading,  ///< readings less the first one of the map, that one taken for exact: the thesis' way, overconfident (A-19)
  kNone,
};

/// What is known of the vehicle when a map starts, before the samples of that tick. Wide: those samples decide.
struct LevelledStartConfig {
  double speed_m_s = 1.5;  ///< forward
  double speed_sigma_m_s = 1.0;
  double depth_sigma_m = 50.0;
  double tilt_sigma_rad = 0.5;  ///< roll and pitch
  double altitude_m = 4.0;
  double altitude_sigma_m = 5.0;
  double rates_sigma_rad_s = 0.2;  ///< where turn rates are states
  // Calibration that every map finds anew, each from this prior: right for what changes from map to map; what is the same in all maps makes
  // their errors alike, which no map can say. 0: not estimated.
  double gyro_bias_sigma_rad_s = 0.0;
  double log_scale_sigma = 0.0;
  double log_yaw_sigma_rad = 0.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("speed_m_s", speed_m_s, Rule::any(), "forward speed expected when a map starts");
    v.field("speed_sigma_m_s", speed_sigma_m_s, Rule::positive(), "each component of the velocity before its first sample");
    v.field("depth_sigma_m", depth_sigma_m, Rule::positive(), "depth before its first sample");
    v.field("tilt_sigma_rad", tilt_sigma_rad, Rule::positive(), "roll and pitch before their first sample");
    v.field("altitude_m", altitude_m, Rule::positive(), "height above the seabed expected when a map starts");
    v.field("altitude_sigma_m", altitude_sigma_m, Rule::positive(), "the same, before its first sample");
    v.field("rates_sigma_rad_s", rates_sigma_rad_s, Rule::positive(), "turn rates when a map starts, where they are states");
    v.field("gyro_bias_sigma_rad_s", gyro_bias_sigma_rad_s, Rule::not_negative(),
            "bias of the gyro, found anew in each map; 0: taken for none");
    v.field("log_scale_sigma", log_scale_sigma, Rule::not_negative(), "scale error of the velocity log, found anew in each map; 0: none");
    v.field("log_yaw_sigma_rad", log_yaw_sigma_rad, Rule::not_negative(),
            "yaw error of the velocity log's mounting, found anew in each map; 0: none");
  }
};

struct LevelledSplitConfig {
  SplitPolicyConfig policy = {30, 0.3, std::nullopt, 100.0, std::nullopt, 2};
  double longest_m = 200.0;        ///< closes a map of whatever landmarks
  bool needs_velocity_fix = true;  ///< close only with the bottom in the velocity log; false for a vehicle without one
  std::optional<double> fix_interval_s = 10.0;
  template <class Visitor>
  void visit(Visitor& v) {
    policy.visit(v);
    v.field("longest_m", longest_m, Rule::positive(), "distance travelled that closes a submap even with fewer landmarks");
    v.field("needs_velocity_fix", needs_velocity_fix,
            "submaps are closed only when the velocity log has the bottom; false for a vehicle without one");
    v.field("fix_interval_s", fix_interval_s, Rule::not_negative(),
            "a position fix closes a submap, at most once in so long; without it fixes are not used");
  }
};

struct LevelledBuilderConfig {
  ConstantVelocityConfig motion;
  AttitudeConfig attitude;
  CompassConfig compass;
  DepthConfig depth;
  AltitudeConfig altitude;
  VelocityLogConfig velocity_log;
  SideScanConfig side_scan;
  CameraConfig camera;
  FrameAssociationConfig camera_association;
  LevelledStartConfig start;
  LevelledSplitConfig split;
  ScanAssociationConfig association;
  CompassUse compass_use = CompassUse::kFilter;
  double max_step_s = 0.2;             ///< a longer time without samples is predicted in several steps
  double trajectory_interval_s = 1.0;  ///< between two remembered poses; 0: every tick
  bool condition_trajectory = true;    ///< false: past poses stay as filtered, and nothing is remembered for them
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("motion", motion, "motion between samples");
    v.section("attitude", attitude, "roll and pitch");
    v.section("compass", compass, "heading");
    v.section("depth", depth, "pressure depth");
    v.section("altitude", altitude, "height above the seabed");
    v.section("velocity_log", velocity_log, "Doppler velocity log");
    v.section("side_scan", side_scan, "side-scan sightings");
    v.section("camera", camera, "the camera: its corrected frames, mounting and noise");
    v.section("camera_association", camera_association, "which keypoint of a frame is of which landmark of the map, and which are new");
    v.section("start", start, "the vehicle when a map starts");
    v.section("split", split, "when a map is closed");
    v.section("association", association, "which sighting is of which landmark of the map");
    v.choice("compass_use", compass_use,
             Choices<CompassUse>{{"filter", CompassUse::kFilter},
                                 {"mean", CompassUse::kMean},
                                 {"first_reading", CompassUse::kFirstReading},
                                 {"none", CompassUse::kNone}},
             "filter: the offset is a state of every map; mean: one mean a map, for an uncalibrated compass; first_reading: the first "
             "reading of a map is taken for exact (overconfident, for comparison); none: not used");
    v.field("max_step_s", max_step_s, Rule::positive(), "a longer time without samples is predicted in several steps");
    v.field("trajectory_interval_s", trajectory_interval_s, Rule::not_negative(), "between two remembered poses; 0 remembers every tick");
    v.field("condition_trajectory", condition_trajectory,
            "past poses of a submap follow its later corrections (costs memory in proportion to a submap)");
  }
};

}  // namespace ssjs
