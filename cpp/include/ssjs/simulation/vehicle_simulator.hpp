/// Drives an Ackerman vehicle along a path and records what its sensors say. docs/scenarios.md.
#pragma once

#include <cstdint>
#include <vector>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/base/progress.hpp"
#include "ssjs/features/event.hpp"
#include "ssjs/simulation/world.hpp"

namespace ssjs {

struct VehicleSimulationConfig {
  AckermanConfig vehicle;  ///< its sigmas are the noise put on the controls, one draw per step, scaled by noise_step_s / step_s
  double speed_m_s = 3.0;  ///< of the rear axle's centre
  double max_steering_rad = 0.5235987755982988;
  double step_s = 0.0125;
  int steps_per_scan = 24;
  double min_range_m = 1.0;
  double max_range_m = 8.0;
  double field_of_view_rad = 2.0 * kPi;  ///< symmetric about straight ahead
  double range_sigma_m = 0.1;
  double bearing_sigma_rad = 0.0174532925199433;
  double lookahead_m = 1.5;
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("vehicle", vehicle, "the vehicle and the noise of its controls");
    v.field("speed_m_s", speed_m_s, Rule::positive(), "true speed of the rear axle's centre");
    v.field("max_steering_rad", max_steering_rad, Rule::open(0.0, 1.5), "the steering stops at it, left and right");
    v.field("step_s", step_s, Rule::positive(), "time between two controls");
    v.field("steps_per_scan", steps_per_scan, Rule::at_least(1), "one scan every so many steps");
    v.field("min_range_m", min_range_m, Rule::not_negative(), "nearer landmarks are not seen");
    v.field("max_range_m", max_range_m, Rule::positive(), "farther landmarks are not seen");
    v.field("field_of_view_rad", field_of_view_rad, Rule{0.0, 2.0 * kPi, true, false}, "half of it to each side; 2 pi sees all round");
    v.field("range_sigma_m", range_sigma_m, Rule::positive(), "range noise");
    v.field("bearing_sigma_rad", bearing_sigma_rad, Rule::positive(), "bearing noise");
    v.field("lookahead_m", lookahead_m, Rule::positive(), "the vehicle aims at the point of the path so far ahead");
  }
};

struct SimulatedMission {
  std::vector<Event> events;          ///< at equal times the AckermanControl before the Features, as in every log
  std::vector<double> time_s;         ///< after every step
  std::vector<Se2> global_T_vehicle;  ///< the truth at those times; global = the start pose
  World world;                        ///< landmarks and waypoints in the same frame
};

/// The vehicle follows the path with the TRUE controls; the log holds them with noise. The truth moves by predict_ackerman, so a filter
/// with the same configuration has the right model. Streams "speed", "steering", "lateral", "range", "bearing" of the seed. A control
/// logged at time t holds from t to t + step_s; the last one is a stop (speed 0) at the end of the path. A scan without a landmark leaves
/// no event. Pursuit is by arc length: the aim moves on along the path, so an unreachable waypoint is passed by, never orbited. Throws
/// InvalidArgument for a path that cannot be driven (fewer than 2 waypoints, or two equal ones in a row), Cancelled.
[[nodiscard]] SimulatedMission simulate(const World& world, const VehicleSimulationConfig& config, std::uint64_t seed,
                                        const ProgressSink& progress = {});

}  // namespace ssjs
