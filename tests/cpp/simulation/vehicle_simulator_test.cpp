#include "ssjs/simulation/vehicle_simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

/// A corner and back, 90 m, among landmarks 5 m apart.
World short_world() {
  World world = exploration_world(9, 9, 5.0, 1.0, 10.0, 5);
  world.waypoints = {{2.5, 2.5}, {32.5, 2.5}, {32.5, 32.5}, {2.5, 32.5}};
  return world;
}

std::vector<AckermanControl> controls_of(const SimulatedMission& mission) {
  std::vector<AckermanControl> controls;
  for (const Event& event : mission.events) {
    if (const auto* control = std::get_if<AckermanControl>(&event.record)) controls.push_back(*control);
  }
  return controls;
}

std::vector<Event> scans_of(const SimulatedMission& mission) {
  std::vector<Event> scans;
  for (const Event& event : mission.events) {
    if (std::holds_alternative<Features>(event.record)) scans.push_back(event);
  }
  return scans;
}

Se2 truth_at(const SimulatedMission& mission, double time_s) {
  const auto found = std::lower_bound(mission.time_s.begin(), mission.time_s.end(), time_s - 1e-9);
  return mission.global_T_vehicle[static_cast<std::size_t>(found - mission.time_s.begin())];
}

TEST(VehicleSimulator, FieldOfViewHidesWhatLiesBehind) {
  VehicleSimulationConfig config;
  config.bearing_sigma_rad = 1e-9;
  config.range_sigma_m = 1e-9;
  const SimulatedMission all_round = simulate(short_world(), config, 2);
  config.field_of_view_rad = kPi;
  const SimulatedMission ahead = simulate(short_world(), config, 2);
  EXPECT_EQ(controls_of(all_round).size(), controls_of(ahead).size());
  const auto counts = [](const SimulatedMission& mission) {
    int in_front = 0, behind = 0;
    for (const Event& event : scans_of(mission)) {
      for (const Feature& feature : std::get<Features>(event.record)) ++(std::abs(feature.bearing()) <= kPi / 2.0 ? in_front : behind);
    }
    return std::pair(in_front, behind);
  };
  EXPECT_GT(counts(all_round).second, 50);
  EXPECT_EQ(counts(ahead).second, 0);
  EXPECT_EQ(counts(ahead).first, counts(all_round).first);
}

TEST(VehicleSimulator, TheFrameIsTheStartPose) {
  World world = short_world();
  std::reverse(world.waypoints.begin(), world.waypoints.end());                              // starts at (2.5, 32.5), heading +x
  std::rotate(world.waypoints.begin(), world.waypoints.begin() + 1, world.waypoints.end());  // (32.5, 32.5), heading -y
  const SimulatedMission mission = simulate(world, VehicleSimulationConfig(), 1);
  EXPECT_NEAR(mission.world.waypoints[0].norm(), 0.0, 1e-12);
  EXPECT_NEAR((mission.world.waypoints[1] - Eigen::Vector2d(30.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_LT(mission.global_T_vehicle.front().translation().norm(), 0.05);  // one step of 3.75 cm
  // a landmark 10 m in front of the start, in the old frame 10 m down in y
  const Eigen::Vector2d field_p_landmark = world.landmarks_m.col(0);
  EXPECT_NEAR(mission.world.landmarks_m(0, 0), 32.5 - field_p_landmark.y(), 1e-12);
  EXPECT_NEAR(mission.world.landmarks_m(1, 0), field_p_landmark.x() - 32.5, 1e-12);
}

TEST(VehicleSimulator, EventsAreInTheOrderOfALog) {
  const VehicleSimulationConfig config;
  const SimulatedMission mission = simulate(short_world(), config, 1);
  ASSERT_EQ(controls_of(mission).size(), mission.time_s.size() + 1);  // one a step, and the stop
  EXPECT_EQ(controls_of(mission).back().speed_m_s, 0.0);
  for (std::size_t i = 1; i < mission.events.size(); ++i) {
    EXPECT_GE(mission.events[i].time_s, mission.events[i - 1].time_s);
    if (std::holds_alternative<Features>(mission.events[i].record)) {
      EXPECT_TRUE(std::holds_alternative<AckermanControl>(mission.events[i - 1].record));
      EXPECT_EQ(mission.events[i].time_s, mission.events[i - 1].time_s);
    }
  }
  const std::vector<Event> scans = scans_of(mission);
  for (std::size_t i = 0; i < scans.size(); ++i) EXPECT_NEAR(scans[i].time_s, 0.3 * static_cast<double>(i + 1), 1e-9);
}

TEST(VehicleSimulator, TheNoiseOfControlsAndScansIsTheConfiguredOne) {
  VehicleSimulationConfig config;
  config.vehicle.speed_sigma_m_s = 0.4;
  config.vehicle.steering_sigma_rad = 0.05;
  config.vehicle.noise_step_s = config.step_s;
  config.vehicle.steering_scale = 1.25;
  config.vehicle.steering_offset_rad = -0.02;
  World world = short_world();
  world.waypoints = {{0.0, 17.5}, {400.0, 17.5}};  // straight: the true controls are 3 m/s and 0 rad
  const SimulatedMission mission = simulate(world, config, 2);
  double speed_sum = 0.0, speed_square = 0.0, steering_sum = 0.0, steering_square = 0.0;
  std::vector<AckermanControl> controls = controls_of(mission);
  controls.pop_back();
  for (const AckermanControl& control : controls) {
    const double speed = control.speed_m_s - 3.0;
    const double steering = control.steering_rad - 0.02 / 1.25;  // the measured value that calibration turns into 0
    speed_sum += speed;
    speed_square += speed * speed;
    steering_sum += steering;
    steering_square += steering * steering;
  }
  const double n = static_cast<double>(controls.size());
  ASSERT_GT(n, 10000.0);
  // deviations: of a mean sigma / 100, of a standard deviation sigma / 141
  EXPECT_NEAR(speed_sum / n, 0.0, 0.02);
  EXPECT_NEAR(std::sqrt(speed_square / n), 0.4, 0.015);
  EXPECT_NEAR(steering_sum / n, 0.0, 0.0025);
  EXPECT_NEAR(std::sqrt(steering_square / n), 0.05, 0.002);
}

TEST(VehicleSimulator, ScansHoldEveryLandmarkInReachWithTheConfiguredNoise) {
  VehicleSimulationConfig config;
  config.max_range_m = 12.0;
  const SimulatedMission mission = simulate(short_world(), config, 3);
  double range_square = 0.0, bearing_square = 0.0;
  int n = 0;
  for (const Event& scan : scans_of(mission)) {
    const Se2 pose = truth_at(mission, scan.time_s);
    const Features& features = std::get<Features>(scan.record);
    std::size_t in_reach = 0;
    for (Eigen::Index i = 0; i < mission.world.landmarks_m.cols(); ++i) {
      const double range = (mission.world.landmarks_m.col(i) - pose.translation()).norm();
      if (range >= 1.0 && range <= 12.0) ++in_reach;
    }
    EXPECT_EQ(features.size(), in_reach);
    for (const Feature& feature : features) {
      const auto id = std::find(mission.world.ids.begin(), mission.world.ids.end(), *feature.landmark_id);
      ASSERT_NE(id, mission.world.ids.end());
      const Eigen::Vector2d global_p_landmark = mission.world.landmarks_m.col(id - mission.world.ids.begin());
      const Eigen::Vector2d exact = predict_range_bearing(pose, global_p_landmark).range_bearing;
      range_square += std::pow(feature.range() - exact.x(), 2);
      bearing_square += std::pow(angle_difference(feature.bearing(), exact.y()), 2);
      EXPECT_NEAR(feature.covariance(0, 0), 0.01, 1e-12);
      EXPECT_GE(feature.bearing(), -kPi);
      EXPECT_LT(feature.bearing(), kPi);
      ++n;
    }
  }
  ASSERT_GT(n, 1000);
  EXPECT_NEAR(std::sqrt(range_square / n), 0.1, 0.01);  // deviation 0.1 / sqrt(2 n) = 0.002
  EXPECT_NEAR(std::sqrt(bearing_square / n), kPi / 180.0, 0.0017);
}

TEST(VehicleSimulator, TheSameSeedGivesTheSameMission) {
  const VehicleSimulationConfig config;
  const SimulatedMission first = simulate(short_world(), config, 9);
  const SimulatedMission second = simulate(short_world(), config, 9);
  const SimulatedMission other = simulate(short_world(), config, 10);
  ASSERT_EQ(first.events.size(), second.events.size());
  const std::vector<AckermanControl> first_controls = controls_of(first);
  const std::vector<AckermanControl> second_controls = controls_of(second);
  for (std::size_t i = 0; i < first_controls.size(); ++i) {
    EXPECT_EQ(first_controls[i].speed_m_s, second_controls[i].speed_m_s);
    EXPECT_EQ(first_controls[i].steering_rad, second_controls[i].steering_rad);
  }
  EXPECT_EQ(std::get<Features>(scans_of(first).back().record).front().range_bearing,
            std::get<Features>(scans_of(second).back().record).front().range_bearing);
  EXPECT_NE(first_controls[5].speed_m_s, controls_of(other)[5].speed_m_s);
}

TEST(VehicleSimulator, ANoiseSourceMovesNoOther) {
  VehicleSimulationConfig config;
  const SimulatedMission plain = simulate(short_world(), config, 9);
  config.bearing_sigma_rad *= 3.0;
  config.max_range_m = 5.0;
  config.vehicle.steering_sigma_rad *= 2.0;
  const SimulatedMission changed = simulate(short_world(), config, 9);
  const std::vector<AckermanControl> plain_controls = controls_of(plain);
  const std::vector<AckermanControl> changed_controls = controls_of(changed);
  ASSERT_EQ(plain_controls.size(), changed_controls.size());
  for (std::size_t i = 0; i < plain_controls.size(); ++i) EXPECT_EQ(plain_controls[i].speed_m_s, changed_controls[i].speed_m_s);
}

TEST(VehicleSimulator, WhiteNoiseKeepsItsDensityWhenTheStepChanges) {
  VehicleSimulationConfig config;
  config.vehicle.noise_step_s = 0.0125;
  config.step_s = 0.05;  // a sample four times as long has half the standard deviation
  World world = short_world();
  world.waypoints = {{0.0, 17.5}, {600.0, 17.5}};
  std::vector<AckermanControl> controls = controls_of(simulate(world, config, 4));
  controls.pop_back();
  double square = 0.0;
  for (const AckermanControl& control : controls) square += std::pow(control.speed_m_s - 3.0, 2);
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(controls.size())), 0.5 * config.vehicle.speed_sigma_m_s, 0.02);
}

TEST(VehicleSimulator, SideSlipIsInTheTruthAndNotInTheControls) {
  VehicleSimulationConfig config;
  const SimulatedMission straight = simulate(short_world(), config, 6);
  config.vehicle.lateral_sigma_m_s = 2.0;
  const SimulatedMission slipping = simulate(short_world(), config, 6);
  // sideways over the first second, before the pursuit reacts much: sigma = 2 * 0.0125 * sqrt(80) * sqrt(0.025 / 0.0125) = 0.32 m
  EXPECT_LT(std::abs(truth_at(straight, 1.0).y), 1e-9);
  EXPECT_GT(std::abs(truth_at(slipping, 1.0).y), 1e-3);
  EXPECT_LT(std::abs(truth_at(slipping, 1.0).y), 1.6);
}

/// Largest distance of the truth from the path, over the places farther than `margin_m` from every corner.
double cross_track_m(const SimulatedMission& mission, double margin_m) {
  double worst_m = 0.0;
  for (const Se2& pose : mission.global_T_vehicle) {
    double nearest_m = 1e9, corner_m = 1e9;
    const std::vector<Eigen::Vector2d>& path = mission.world.waypoints;
    for (std::size_t i = 0; i < path.size(); ++i) {
      corner_m = std::min(corner_m, (path[i] - pose.translation()).norm());
      if (i + 1 == path.size()) break;
      const Eigen::Vector2d along = path[i + 1] - path[i];
      const double share = std::clamp(along.dot(pose.translation() - path[i]) / along.squaredNorm(), 0.0, 1.0);
      nearest_m = std::min(nearest_m, (path[i] + share * along - pose.translation()).norm());
    }
    if (corner_m > margin_m) worst_m = std::max(worst_m, nearest_m);
  }
  return worst_m;
}

TEST(VehicleSimulator, ThePursuitHoldsThePathWhereverTheReferencePointIs) {
  World world = short_world();
  world.waypoints = {{0.0, 0.0}, {60.0, 0.0}, {60.0, 60.0}, {0.0, 60.0}};
  VehicleSimulationConfig config;
  EXPECT_LT(cross_track_m(simulate(world, config, 1), 20.0), 0.1);
  config.vehicle.reference_forward_m = 0.0;  // the rear axle itself
  config.vehicle.reference_left_m = 0.0;
  EXPECT_LT(cross_track_m(simulate(world, config, 1), 20.0), 0.1);
}

TEST(VehicleSimulator, AnUnreachableWaypointIsPassedBy) {
  const auto driven_m = [](const SimulatedMission& mission) { return static_cast<double>(mission.time_s.size()) * 3.0 * 0.0125; };
  // zigzags far tighter than the turning circle of 4.9 m
  World world = short_world();
  world.waypoints = {{0.0, 0.0}, {20.0, 0.0}, {20.0, 1.0}, {0.0, 1.0}, {0.0, 2.0}, {20.0, 2.0}};
  VehicleSimulationConfig config;
  EXPECT_LE(driven_m(simulate(world, config, 1)), 2.0 * path_length_m(world) + 0.1);
  EXPECT_GE(driven_m(simulate(world, config, 1)), 0.5 * path_length_m(world));
  // a turning circle of 2.83 / tan(0.01) = 283 m beside legs of 30 m: turning back alone would take 283 pi = 889 m;
  // half of what is driven counts, so the 90 m end after 180
  config.max_steering_rad = 0.01;
  EXPECT_LE(driven_m(simulate(short_world(), config, 1)), 2.0 * 90.0 + 0.1);
}

TEST(VehicleSimulator, ACallerCanStopIt) {
  int reports = 0;
  const ProgressSink stop = [&](double fraction) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
    return ++reports < 2;
  };
  EXPECT_THROW((void)simulate(grid_survey_world(), VehicleSimulationConfig(), 1, stop), Cancelled);
  EXPECT_EQ(reports, 2);
}

TEST(VehicleSimulator, BrokenContractsAreNamed) {
  VehicleSimulationConfig config;
  config.speed_m_s = 0.0;
  EXPECT_THROW((void)simulate(short_world(), config, 1), InvalidArgument);
  config = VehicleSimulationConfig();
  config.min_range_m = config.max_range_m;
  EXPECT_THROW((void)simulate(short_world(), config, 1), InvalidArgument);
  World world = short_world();
  world.waypoints.resize(1);
  EXPECT_THROW((void)simulate(world, VehicleSimulationConfig(), 1), InvalidArgument);
  world = short_world();
  world.waypoints[1] = world.waypoints[0];
  EXPECT_THROW((void)simulate(world, VehicleSimulationConfig(), 1), InvalidArgument);
  world = short_world();
  world.ids.pop_back();
  EXPECT_THROW((void)simulate(world, VehicleSimulationConfig(), 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
