#include "ssjs/simulation/auv_survey.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/point_grid.hpp"
#include "ssjs/simulation/route.hpp"

namespace ssjs {
namespace {

Eigen::Vector3d normal3(Rng& rng, double sigma) {
  Eigen::Vector3d noise;
  for (Eigen::Index i = 0; i < 3; ++i) noise(i) = rng.normal(sigma);
  return noise;
}

/// x <- x + pull towards the mean + walk: within a time constant a random walk.
double walked(double x, double mean, double time_constant_s, double walk, double dt_s, Rng& rng) {
  return x + (mean - x) * dt_s / time_constant_s + rng.normal(walk * std::sqrt(dt_s));
}

/// Keeps the vehicle on the lines: a heading that a turn of at most so many rad/s reaches.
class Helmsman {
 public:
  Helmsman(const std::vector<Eigen::Vector2d>& waypoints, const AuvSimulationConfig& config) : route_(waypoints), config_(config) {}

  [[nodiscard]] bool finished() const { return arc_m_ >= route_.length_m(); }
  [[nodiscard]] std::size_t leg() const { return route_.leg_at(arc_m_); }

  [[nodiscard]] double yaw_rate_rad_s(const Eigen::Vector2d& position, double yaw) const {
    constexpr double kPerSecond = 0.5;  // of the heading error
    const Eigen::Vector2d ahead = route_.at(arc_m_ + config_.lookahead_m) - position;
    const double error = angle_difference(std::atan2(ahead.y(), ahead.x()), yaw);
    return std::clamp(kPerSecond * error, -config_.turn_rate_rad_s, config_.turn_rate_rad_s);
  }

  /// Half the distance driven counts even where the path is out of reach: no circling for ever.
  void advance(const Eigen::Vector2d& position, double driven_m) {
    const double window_m = config_.lookahead_m + driven_m;
    arc_m_ = std::max(arc_m_ + 0.5 * driven_m, route_.nearest_ahead(position, arc_m_, window_m));
  }

 private:
  Route route_;
  const AuvSimulationConfig& config_;
  double arc_m_ = 0.0;
};

/// Gaps and single losses of the velocity log.
class BottomLock {
 public:
  BottomLock(const AuvSimulationConfig& config, const Rng& rng) : config_(config), rng_(rng.stream("velocity loss")) {
    gap_begin_s_ = time_to_next_gap();
  }

  [[nodiscard]] bool at(double time_s) {
    if (time_s >= gap_begin_s_ + config_.velocity_gap_s) gap_begin_s_ = time_s + time_to_next_gap();
    const bool lost = rng_.uniform() < config_.velocity_loss_fraction;
    const bool gap = config_.velocity_gap_s > 0.0 && time_s >= gap_begin_s_;
    const bool out = std::any_of(config_.velocity_outages.begin(), config_.velocity_outages.end(),
                                 [&](const Outage& outage) { return time_s >= outage.begin_s && time_s < outage.end_s; });
    return !lost && !gap && !out;
  }

 private:
  [[nodiscard]] double time_to_next_gap() { return -config_.velocity_gap_every_s * std::log(1.0 - rng_.uniform()); }

  const AuvSimulationConfig& config_;
  Rng rng_;
  double gap_begin_s_ = 0.0;
};

constexpr double kWellAway_m = 50.0;

/// What the sensors say at a true state.
class SensorSuite {
 public:
  SensorSuite(const SurveyWorld& world, const AuvSimulationConfig& config, const Rng& rng)
      : world_(world),
        config_(config),
        gyro_(rng.stream("gyro")),
        attitude_(rng.stream("attitude")),
        compass_(rng.stream("compass")),
        depth_(rng.stream("depth")),
        altitude_(rng.stream("altitude")),
        velocity_(rng.stream("velocity")),
        side_scan_(rng.stream("side scan")),
        sample_loss_(rng.stream("sample loss")),
        fix_(rng.stream("fix")),
        mirrored_(rng.stream("mirrored")),
        clutter_(rng.stream("clutter")),
        bottom_lock_(config, rng),
        near_m_(2.0 * config.max_across_m + kWellAway_m),
        near_(world.landmarks_m.topRows<2>(), near_m_),
        along_(static_cast<std::size_t>(world.landmarks_m.cols())) {}

  [[nodiscard]] NavigationTick tick(std::size_t step, const AuvTruth& truth) {
    const Eigen::Vector3d& rpy = truth.world_T_vehicle.rpy;
    NavigationTick tick;
    tick.time_s = truth.time_s;
    const double gyro_sigma = config_.motion.gyro_sigma_rad_s * std::sqrt(config_.motion.gyro_step_s / config_.step_s);
    if (config_.motion.drive == RotationDrive::kGyro) {
      tick.gyro_rad_s = truth.rates_rad_s + config_.gyro_bias_rad_s + normal3(gyro_, gyro_sigma);
    }
    if (due(step, config_.steps_per_attitude, 0) && !lost()) {
      tick.roll_pitch_rad = Eigen::Vector2d(wrap_angle(rpy.x() + attitude_.normal(config_.attitude.sigma_rad)),
                                            wrap_angle(rpy.y() + attitude_.normal(config_.attitude.sigma_rad)));
    }
    if (due(step, config_.steps_per_compass, config_.phase_steps) && !lost()) {
      tick.compass_rad = wrap_angle(rpy.z() + truth.compass_offset_rad + compass_.normal(config_.compass.sigma_rad));
    }
    const double z = truth.world_T_vehicle.translation.z();
    if (due(step, config_.steps_per_depth, config_.phase_steps) && !lost()) {
      tick.depth_m = z + tide_m(truth.time_s) + depth_.normal(config_.depth.sigma_m);
    }
    if (due(step, config_.steps_per_altitude, config_.phase_steps) && !lost()) {
      const double slant = config_.altitude.along_body_axis ? 1.0 / (std::cos(rpy.x()) * std::cos(rpy.y())) : 1.0;
      tick.altitude_m = (truth.seabed_m - z) * slant + altitude_.normal(config_.altitude.sigma_m);
    }
    if (due(step, config_.steps_per_velocity, 0)) tick.velocity = velocity_sample(truth);
    if (config_.fix_interval_s && z <= config_.fix_depth_m && truth.time_s >= next_fix_s_) {
      const double sigma = config_.fix_sigma_m;
      Eigen::Vector2d position = truth.world_T_vehicle.translation.head<2>();
      for (double& coordinate : position) coordinate += fix_.normal(sigma);
      tick.fix = PositionFix{position, sigma * sigma * Eigen::Matrix2d::Identity(), false};
      next_fix_s_ = truth.time_s + *config_.fix_interval_s * (1.0 - 1e-9);
    }
    tick.sightings = sightings(truth);
    add_false_sightings(truth, tick.sightings);
    return tick;
  }

 private:
  [[nodiscard]] static bool due(std::size_t step, int every, int phase) {
    const auto n = static_cast<std::size_t>(every);
    return step % n == static_cast<std::size_t>(phase) % n;
  }
  [[nodiscard]] bool lost() { return config_.sample_loss_fraction > 0.0 && sample_loss_.uniform() < config_.sample_loss_fraction; }

  [[nodiscard]] VelocitySample velocity_sample(const AuvTruth& truth) {
    const VelocityLogConfig& log = config_.velocity_log;
    const Eigen::Matrix3d log_R_vehicle = rotation_from_rpy({log.mount_roll_rad, log.mount_pitch_rad, log.mount_yaw_rad}).transpose();
    const Eigen::Vector3d lever(log.mount_forward_m, log.mount_starboard_m, log.mount_down_m);
    VelocitySample sample;
    const Eigen::Matrix3d more = rotation_from_rpy({0.0, 0.0, config_.velocity_log_yaw_rad}).transpose();
    sample.velocity_m_s =
        (1.0 + config_.velocity_log_scale) * log_R_vehicle * more * (truth.velocity_m_s + skew(truth.rates_rad_s) * lever) +
        normal3(velocity_, log.sigma_m_s);
    sample.bottom_lock = bottom_lock_.at(truth.time_s);
    return sample;
  }

  /// A landmark is seen once a pass, at the tick after it came abeam.
  [[nodiscard]] SideScanSightings sightings(const AuvTruth& truth) {
    const Eigen::Matrix3d vehicle_R_world = truth.world_T_vehicle.rotation().transpose();
    const bool turning = std::abs(truth.rates_rad_s.z()) > config_.max_turn_rate_rad_s;
    SideScanSightings seen;
    ++ticks_;
    for (const Eigen::Index i : near_.within(truth.world_T_vehicle.translation.head<2>(), near_m_)) {
      const Eigen::Vector3d p = vehicle_R_world * (world_.landmarks_m.col(i) - truth.world_T_vehicle.translation);
      const Along before = std::exchange(along_[static_cast<std::size_t>(i)], {p.x(), ticks_});
      const bool came_abeam = before.tick == ticks_ - 1 && before.x_m > 0.0 && p.x() <= 0.0;
      if (!came_abeam || turning || std::abs(p.y()) < config_.min_across_m || std::abs(p.y()) > config_.max_across_m) continue;
      SideScanSighting sighting;
      const double range = p.norm();
      const Eigen::Matrix3d covariance = side_scan_covariance(range, truth.velocity_m_s.norm(), config_.side_scan);
      const Eigen::Vector3d noise = normal3(side_scan_, 1.0);
      if (config_.side_scan.form == SideScanForm::kFlatBottom) {
        sighting.vehicle_p_point = {p.x(), std::copysign(range, p.y()), 0.0};
      } else {
        sighting.vehicle_p_point = p;
        sighting.vehicle_p_point.z() += std::sqrt(covariance(2, 2)) * noise.z();
      }
      sighting.vehicle_p_point.x() += std::sqrt(covariance(0, 0)) * noise.x();
      sighting.vehicle_p_point.y() += std::sqrt(covariance(1, 1)) * noise.y();
      sighting.covariance = covariance;
      sighting.landmark_id = world_.ids[static_cast<std::size_t>(i)];
      seen.push_back(sighting);
    }
    return seen;
  }

  [[nodiscard]] double tide_m(double time_s) const {
    return config_.tide_m > 0.0 ? config_.tide_m * std::sin(2.0 * kPi * time_s / config_.tide_period_s) : 0.0;
  }

  /// cross talk shows an object on both sides; clutter is anywhere in the swath, at the depth of the seabed.
  void add_false_sightings(const AuvTruth& truth, SideScanSightings& seen) {
    const bool turning = std::abs(truth.rates_rad_s.z()) > config_.max_turn_rate_rad_s;
    const std::size_t real = seen.size();
    for (std::size_t i = 0; i < real; ++i) {
      if (mirrored_.uniform() >= config_.mirrored_fraction) continue;
      seen.push_back(seen[i]);
      seen.back().vehicle_p_point.y() *= -1.0;
      seen.back().landmark_id = next_clutter_id_++;
    }
    if (turning || clutter_.uniform() >= config_.clutter_per_s * config_.step_s) return;
    const double across = std::copysign(clutter_.uniform(config_.min_across_m, config_.max_across_m), clutter_.uniform() - 0.5);
    const double down = truth.seabed_m - truth.world_T_vehicle.translation.z();
    const double range = std::hypot(across, down);
    SideScanSighting sighting;
    const bool flat = config_.side_scan.form == SideScanForm::kFlatBottom;
    sighting.vehicle_p_point = flat ? Eigen::Vector3d(0.0, std::copysign(range, across), 0.0) : Eigen::Vector3d(0.0, across, down);
    sighting.covariance = side_scan_covariance(range, truth.velocity_m_s.norm(), config_.side_scan);
    sighting.landmark_id = next_clutter_id_++;
    seen.push_back(sighting);
  }

  const SurveyWorld& world_;
  const AuvSimulationConfig& config_;
  Rng gyro_, attitude_, compass_, depth_, altitude_, velocity_, side_scan_, sample_loss_, fix_, mirrored_, clutter_;
  double next_fix_s_ = 0.0;
  std::int64_t next_clutter_id_ = kFirstClutterId;
  BottomLock bottom_lock_;
  /// Body x of a landmark at the last tick at which it was near.
  struct Along {
    double x_m = 0.0;
    std::int64_t tick = 0;
  };
  std::int64_t ticks_ = 1;
  double near_m_;  ///< what comes abeam within the swath was inside a tick ago, however the vehicle leans
  PointGrid near_;
  std::vector<Along> along_;
};

void check(const SurveyWorld& world, const AuvSimulationConfig& config) {
  throw_if_any(violations(config));
  if (!(config.max_across_m > config.min_across_m)) {
    throw InvalidArgument("AuvSimulationConfig.max_across_m", config.max_across_m, "must be above min_across_m");
  }
  if (world.ids.size() != static_cast<std::size_t>(world.landmarks_m.cols())) {
    throw InvalidArgument("SurveyWorld.ids", std::to_string(world.ids.size()) + " entries",
                          "must have one per landmark (" + std::to_string(world.landmarks_m.cols()) + ")");
  }
  if (!world.dives.empty() && world.dives.size() + 1 != world.waypoints.size()) {
    throw InvalidArgument("SurveyWorld.dives", std::to_string(world.dives.size()) + " entries", "must have one per leg");
  }
}

double depth_on_leg(const SurveyWorld& world, const AuvSimulationConfig& config, std::size_t leg) {
  if (world.dives.empty()) return config.depth_m;
  const std::optional<int> dive = world.dives[leg];
  return dive ? config.depth_m + *dive * config.dive_step_m : config.surface_depth_m;
}

std::vector<Eigen::Vector2d> lines_and_cross_lines(const SurveyWorldConfig& config) {
  std::vector<Eigen::Vector2d> waypoints;
  const double width_m = config.line_spacing_m * (config.lines - 1);
  for (int line = 0; line < config.lines; ++line) {
    const bool north = line % 2 == 0;
    waypoints.emplace_back(north ? 0.0 : config.line_length_m, config.line_spacing_m * line);
    waypoints.emplace_back(north ? config.line_length_m : 0.0, config.line_spacing_m * line);
  }
  // cross lines at even distances, the nearest to the end of the last line first
  const bool ends_north = config.lines % 2 == 1;
  for (int cross = 0; cross < config.cross_lines; ++cross) {
    const double from_end_m = config.line_length_m * (cross + 0.5) / config.cross_lines;
    const double x = ends_north ? config.line_length_m - from_end_m : from_end_m;
    const bool west = cross % 2 == 0;
    const double low_m = -config.cross_margin_m;
    const double high_m = width_m + config.cross_margin_m;
    waypoints.emplace_back(x, west ? high_m : low_m);
    waypoints.emplace_back(x, west ? low_m : high_m);
  }
  return waypoints;
}

}  // namespace

SurveyWorld survey_world(const SurveyWorldConfig& config, std::uint64_t seed) {
  throw_if_any(violations(config));
  SurveyWorld world;
  const double width_m = config.line_spacing_m * (config.lines - 1);
  const std::vector<Eigen::Vector2d> once = lines_and_cross_lines(config);
  if (config.surface_start) {
    world.waypoints.emplace_back(-2.0 * config.run_in_m, 0.0);
    world.waypoints.emplace_back(-config.run_in_m, 0.0);
    world.dives.emplace_back(std::nullopt);
    world.dives.emplace_back(0);
  }
  for (int dive = 0; dive < config.dives; ++dive) {
    if (dive > 0) {
      world.waypoints.emplace_back(-config.run_in_m, 0.0);
      world.dives.emplace_back(std::nullopt);
      world.dives.emplace_back(dive);
    }
    world.waypoints.insert(world.waypoints.end(), once.begin(), once.end());
    world.dives.insert(world.dives.end(), once.size() - 1, dive);
  }
  Rng places = Rng(seed).stream("landmarks");
  world.landmarks_m.resize(3, config.landmarks);
  for (int i = 0; i < config.landmarks; ++i) {
    const double x = places.uniform(-config.landmark_margin_m, config.line_length_m + config.landmark_margin_m);
    const double y = places.uniform(-config.landmark_margin_m, width_m + config.landmark_margin_m);
    world.landmarks_m.col(i) << x, y, config.seabed_depth_m + places.normal(config.landmark_height_sigma_m);
    world.ids.push_back(i);
  }
  return world;
}

SimulatedSurvey simulate_survey(const SurveyWorld& world, const AuvSimulationConfig& config, std::uint64_t seed,
                                const SeabedDepth& seabed) {
  check(world, config);
  SimulatedSurvey survey;
  survey.world = world;
  Helmsman helmsman(world.waypoints, config);
  const Rng rng(seed);
  SensorSuite sensors(survey.world, config, rng);
  Rng velocity_walk = rng.stream("velocity walk");
  Rng seabed_walk = rng.stream("seabed walk");
  Rng compass_walk = rng.stream("compass walk");

  const double dt = config.step_s;
  const double seabed_mean = world.landmarks_m.cols() > 0 ? world.landmarks_m.row(2).mean() : config.depth_m + 4.0;
  const Eigen::Vector2d first_leg = world.waypoints[1] - world.waypoints[0];
  const Eigen::Vector3d cruise(config.speed_m_s, 0.0, 0.0);
  AuvTruth truth;
  truth.world_T_vehicle.translation << world.waypoints[0], depth_on_leg(world, config, 0);
  truth.world_T_vehicle.rpy.z() = std::atan2(first_leg.y(), first_leg.x());
  truth.velocity_m_s = cruise;
  truth.seabed_m = seabed ? seabed(world.waypoints[0]) : seabed_mean;
  double walked_offset = config.compass_offset_rad;

  for (std::size_t step = 0;; ++step) {
    truth.time_s = static_cast<double>(step) * dt;
    Eigen::Vector3d& rpy = truth.world_T_vehicle.rpy;
    Eigen::Vector3d& position = truth.world_T_vehicle.translation;
    truth.compass_offset_rad = wrap_angle(walked_offset + config.compass_deviation_rad * std::sin(rpy.z()));
    // the attitude follows the helm; the body rates are those that the model turns it by
    const double yaw_rate = helmsman.yaw_rate_rad_s(position.head<2>(), rpy.z());
    const double off_depth_m = position.z() - depth_on_leg(world, config, helmsman.leg());
    const double to_depth_rad = std::clamp(config.depth_gain_rad_m * off_depth_m, -0.25, 0.25);
    const double roll_aim = 0.3 * yaw_rate + 0.03 * std::sin(0.9 * truth.time_s);
    const double pitch_aim = to_depth_rad + 0.02 * std::sin(0.5 * truth.time_s);
    const Eigen::Vector3d euler_rates(0.8 * (roll_aim - rpy.x()), 0.8 * (pitch_aim - rpy.y()), yaw_rate);
    truth.rates_rad_s = euler_rate_matrix(rpy) * euler_rates;
    survey.ticks.push_back(sensors.tick(step, truth));
    survey.truth.push_back(truth);
    if (helmsman.finished() || (config.duration_s && truth.time_s >= *config.duration_s)) break;

    Eigen::Vector3d velocity;
    for (Eigen::Index i = 0; i < 3; ++i) {
      velocity(i) = walked(truth.velocity_m_s(i), cruise(i), config.velocity_time_constant_s, config.motion.velocity_walk_m_s_sqrt_s, dt,
                           velocity_walk);
    }
    position += 0.5 * dt * (truth.world_T_vehicle.rotation() * (truth.velocity_m_s + velocity));
    for (Eigen::Index i = 0; i < 3; ++i) rpy(i) = wrap_angle(rpy(i) + dt * euler_rates(i));
    truth.velocity_m_s = velocity;
    truth.seabed_m =
        walked(truth.seabed_m, seabed_mean, config.seabed_time_constant_s, config.motion.seabed_walk_m_sqrt_s, dt, seabed_walk);
    if (seabed) truth.seabed_m = seabed(position.head<2>());
    walked_offset += compass_walk.normal(config.motion.compass_walk_rad_sqrt_s * std::sqrt(dt));
    helmsman.advance(position.head<2>(), config.speed_m_s * dt);
  }
  return survey;
}

}  // namespace ssjs
