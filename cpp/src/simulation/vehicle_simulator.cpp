#include "ssjs/simulation/vehicle_simulator.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/point_grid.hpp"
#include "ssjs/sensors/range_bearing.hpp"
#include "ssjs/simulation/route.hpp"

namespace ssjs {
namespace {

/// Steers the reference point onto a point of the route ahead of it.
class Pursuit {
 public:
  Pursuit(Route route, const VehicleSimulationConfig& config)
      : route_(std::move(route)), config_(config), max_curvature_(std::tan(config.max_steering_rad) / config.vehicle.wheelbase_m) {}

  [[nodiscard]] bool finished() const { return arc_m_ >= route_.length_m(); }
  [[nodiscard]] double progress() const { return std::min(arc_m_ / route_.length_m(), 1.0); }

  /// Follows the vehicle along the route. Half the distance driven counts even where the route is out of reach: no circling for ever.
  void advance(const Se2& global_T_vehicle, double driven_m) {
    constexpr double kLeastProgress = 0.5;
    const double window_m = 3.0 * config_.lookahead_m + driven_m;  // less than a turn between two lines, or lines would be skipped
    arc_m_ = std::max(arc_m_ + kLeastProgress * driven_m, route_.nearest_ahead(global_T_vehicle.translation(), arc_m_, window_m));
  }

  /// Angle of the wheels that brings the reference point through the aim on one arc, within the steering's stops.
  [[nodiscard]] double steering_rad(const Se2& global_T_vehicle) const {
    const Eigen::Vector2d vehicle_p_aim = global_T_vehicle.inverse() * route_.at(arc_m_ + config_.lookahead_m);
    // the rear axle turns about (0, 1/curvature) in its own frame: equal distances of reference point and aim from there give the curvature
    const Eigen::Vector2d axle_p_reference(config_.vehicle.reference_forward_m, config_.vehicle.reference_left_m);
    const Eigen::Vector2d axle_p_aim = axle_p_reference + vehicle_p_aim;
    const double left_m = vehicle_p_aim.y();
    const double squared_gain = axle_p_aim.squaredNorm() - axle_p_reference.squaredNorm();
    const double hardest = std::copysign(max_curvature_, left_m);
    const double curvature = 2.0 * std::abs(left_m) < max_curvature_ * squared_gain ? 2.0 * left_m / squared_gain : hardest;
    return std::atan(curvature * config_.vehicle.wheelbase_m);
  }

 private:
  Route route_;
  const VehicleSimulationConfig& config_;
  double max_curvature_;  ///< 1/m
  double arc_m_ = 0.0;
};

World seen_from(const World& world, const Se2& global_T_field) {
  World moved = world;
  for (Eigen::Index i = 0; i < moved.landmarks_m.cols(); ++i)
    moved.landmarks_m.col(i) = global_T_field * Eigen::Vector2d(world.landmarks_m.col(i));
  for (Eigen::Vector2d& waypoint : moved.waypoints) waypoint = global_T_field * waypoint;
  return moved;
}

Se2 start_pose(const World& world) {
  const Eigen::Vector2d ahead = world.waypoints[1] - world.waypoints[0];
  return {world.waypoints[0].x(), world.waypoints[0].y(), wrap_angle(std::atan2(ahead.y(), ahead.x()))};
}

/// What the range-bearing sensor says about the landmarks around the true pose, in the order of their indices.
class Scanner {
 public:
  Scanner(const World& world, const VehicleSimulationConfig& config, const Rng& rng)
      : world_(world),
        config_(config),
        grid_(world.landmarks_m, config.max_range_m),
        range_(rng.stream("range")),
        bearing_(rng.stream("bearing")) {
    covariance_ << config.range_sigma_m * config.range_sigma_m, 0.0, 0.0, config.bearing_sigma_rad * config.bearing_sigma_rad;
  }

  [[nodiscard]] Features scan(const Se2& global_T_vehicle) {
    constexpr double kOnLandmarkMetres = 1e-6;  // no bearing there
    Features features;
    for (const Eigen::Index i : grid_.within(global_T_vehicle.translation(), config_.max_range_m)) {
      const Eigen::Vector2d global_p_landmark = world_.landmarks_m.col(i);
      if ((global_p_landmark - global_T_vehicle.translation()).norm() < std::max(config_.min_range_m, kOnLandmarkMetres)) continue;
      const Eigen::Vector2d truth = predict_range_bearing(global_T_vehicle, global_p_landmark).range_bearing;
      if (std::abs(truth.y()) > 0.5 * config_.field_of_view_rad) continue;
      Feature feature;
      feature.range_bearing << truth.x() + range_.normal(config_.range_sigma_m),
          wrap_angle(truth.y() + bearing_.normal(config_.bearing_sigma_rad));
      feature.covariance = covariance_;
      feature.landmark_id = world_.ids[static_cast<std::size_t>(i)];
      if (feature.range() > 0.0) features.push_back(feature);
    }
    return features;
  }

 private:
  const World& world_;
  const VehicleSimulationConfig& config_;
  PointGrid grid_;
  Rng range_, bearing_;
  Eigen::Matrix2d covariance_;
};

void check(const World& world, const VehicleSimulationConfig& config) {
  throw_if_any(violations(config));
  if (!(config.max_range_m > config.min_range_m)) {
    throw InvalidArgument("VehicleSimulationConfig.max_range_m", config.max_range_m, "must be above min_range_m");
  }
  if (world.ids.size() != static_cast<std::size_t>(world.landmarks_m.cols())) {
    throw InvalidArgument("World.ids", std::to_string(world.ids.size()) + " entries",
                          "must have one per landmark (" + std::to_string(world.landmarks_m.cols()) + ")");
  }
}

}  // namespace

SimulatedMission simulate(const World& world, const VehicleSimulationConfig& config, std::uint64_t seed, const ProgressSink& progress) {
  check(world, config);
  const Route field_route(world.waypoints);  // refuses a path that cannot be driven before its start is asked for
  SimulatedMission mission;
  mission.world = seen_from(world, start_pose(world).inverse());
  Pursuit pursuit(Route(mission.world.waypoints), config);

  const Rng rng(seed);
  Scanner scanner(mission.world, config, rng);
  Rng speed_noise = rng.stream("speed");
  Rng steering_noise = rng.stream("steering");
  Rng lateral_noise = rng.stream("lateral");
  const AckermanConfig& vehicle = config.vehicle;
  const double per_step = std::sqrt(vehicle.noise_step_s / config.step_s);  // white noise: variance inverse to the length of the sample
  const double driven_m = config.speed_m_s * config.step_s;

  const std::size_t expected_steps = static_cast<std::size_t>(1.1 * field_route.length_m() / driven_m) + 1;
  mission.time_s.reserve(expected_steps);
  mission.global_T_vehicle.reserve(expected_steps);
  mission.events.reserve(expected_steps + expected_steps / static_cast<std::size_t>(config.steps_per_scan) + 2);

  Se2 global_T_vehicle;
  std::size_t steps = 0;
  const auto time_s = [&] { return static_cast<double>(steps) * config.step_s; };
  const auto record_scan = [&] {
    if (steps == 0 || steps % static_cast<std::size_t>(config.steps_per_scan) != 0) return;
    Features features = scanner.scan(global_T_vehicle);
    if (!features.empty()) mission.events.push_back({time_s(), std::move(features)});
  };
  constexpr std::size_t kStepsPerReport = 4096;
  while (!pursuit.finished()) {
    if (progress && steps % kStepsPerReport == 0 && !progress(pursuit.progress())) throw Cancelled();
    const double steering = pursuit.steering_rad(global_T_vehicle);
    // the encoder wheel runs inside or outside the rear axle's arc
    const double wheel_speed = config.speed_m_s * (1.0 - std::tan(steering) * vehicle.encoder_offset_m / vehicle.wheelbase_m);
    const AckermanControl exact{wheel_speed, (steering - vehicle.steering_offset_rad) / vehicle.steering_scale};
    const AckermanControl measured{exact.speed_m_s + speed_noise.normal(vehicle.speed_sigma_m_s * per_step),
                                   exact.steering_rad + steering_noise.normal(vehicle.steering_sigma_rad * per_step)};
    mission.events.push_back({time_s(), measured});
    record_scan();

    const Se2 before = global_T_vehicle;
    global_T_vehicle = predict_ackerman(before, exact, config.step_s, vehicle).submap_T_vehicle;
    const double slip_m = config.step_s * lateral_noise.normal(vehicle.lateral_sigma_m_s * per_step);
    global_T_vehicle.x -= slip_m * std::sin(before.heading);
    global_T_vehicle.y += slip_m * std::cos(before.heading);
    ++steps;
    mission.time_s.push_back(time_s());
    mission.global_T_vehicle.push_back(global_T_vehicle);
    pursuit.advance(global_T_vehicle, driven_m);
  }
  mission.events.push_back({time_s(), AckermanControl{}});
  record_scan();
  if (progress && !progress(1.0)) throw Cancelled();
  return mission;
}

}  // namespace ssjs
