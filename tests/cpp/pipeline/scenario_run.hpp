/// Runs a simulated mission through the pipeline and measures it against the truth: shared by the scenario tests and benchmarks.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/evaluation/map_error.hpp"
#include "ssjs/pipeline/slam_pipeline.hpp"
#include "ssjs/simulation/scenario.hpp"

namespace ssjs::testing {

struct ScenarioResult {
  int submaps = 0, fusions = 0, loop_closures = 0, live_maps = 0, candidates = 0, landmarks = 0;
  int scan_wrong_pairs = 0, map_wrong_pairs = 0, map_pairs = 0, exhausted = 0;
  double map_mean_m = 0, map_max_m = 0, aligned_mean_m = 0;
  double online_mean_m = 0, online_max_m = 0;  ///< at the submap borders
  double final_m = 0, dead_reckoning_final_m = 0;
  double joint_nees_per_dof = 0, base_nees_mean = 0, trajectory_nees_mean = 0, online_nees_mean = 0;
  std::vector<double> link_nees;
  double fusion_chi_squared = 0;
  int fusion_dof = 0;
  double total_s = 0, local_s = 0, global_s = 0, association_s = 0;
  std::vector<double> base_nees;
};

inline const Se2& truth_at(const SimulatedMission& mission, double time_s) {
  const auto found = std::lower_bound(mission.time_s.begin(), mission.time_s.end(), time_s - 1e-9);
  const auto index = std::min<std::ptrdiff_t>(found - mission.time_s.begin(), static_cast<std::ptrdiff_t>(mission.time_s.size()) - 1);
  return mission.global_T_vehicle[static_cast<std::size_t>(index)];
}

/// The filter's noise is the simulated noise.
inline SlamConfig matching_config(const VehicleSimulationConfig& simulation) {
  SlamConfig config;
  config.vehicle.ackerman = simulation.vehicle;
  config.vehicle.ackerman.noise_step_s = simulation.step_s;
  config.sensor.range_sigma_m = simulation.range_sigma_m;
  config.sensor.bearing_sigma_rad = simulation.bearing_sigma_rad;
  config.submap.split.max_sigma_xy_m.reset();
  config.submap.split.min_landmarks = 0;
  config.association.method = AssociationMethod::kKnown;
  return config;
}

/// What a method says about one base by itself; base k > 0 starts submap k, the last one ends the mission.
inline Eigen::Matrix3d base_covariance(const WorldEstimate& world, Eigen::Index k) {
  if (world.base_covariance.size() > 0) return world.base_covariance.block<3, 3>(3 * k, 3 * k);
  const auto at = static_cast<std::size_t>(k);
  if (at < world.border_covariance.size()) return world.border_covariance[at].topLeftCorner<3, 3>();
  return world.border_covariance.back().bottomRightCorner<3, 3>();
}

inline ScenarioResult run_scenario(const SimulatedMission& mission, const SlamConfig& config, std::uint64_t seed) {
  ScenarioResult result;
  SlamPipeline pipeline(config, seed);
  std::vector<double> online_errors;
  std::vector<double> border_times;
  double online_nees = 0;
  int online_count = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto take = [&](const JoinReport& join) {
    result.candidates += join.candidates;
    result.exhausted += join.budget_exhausted ? 1 : 0;
    result.fusions += join.fusions;
    for (const NeighbourJoin& neighbours : join.neighbours) {
      result.map_pairs += neighbours.pairs;
      result.map_wrong_pairs += neighbours.wrong_pairs.value_or(0);
      result.fusion_chi_squared += neighbours.chi_squared;
      result.fusion_dof += neighbours.dof;
    }
    for (const LoopAttempt& loop : join.loops) {
      if (!loop.accepted) continue;
      ++result.loop_closures;
      result.map_pairs += loop.pairs;
      result.map_wrong_pairs += loop.wrong_pairs.value_or(0);
      result.fusion_chi_squared += loop.chi_squared.value_or(0.0);
      result.fusion_dof += loop.dof;
    }
  };
  for (const Event& event : mission.events) {
    const StepReport step = pipeline.feed(event);
    result.global_s += step.global_time_s;
    result.association_s += step.association_time_s;
    if (step.scan) result.scan_wrong_pairs += step.scan->wrong_pairs;
    if (step.join) {
      take(*step.join);
      const Eigen::Vector3d error = additive_difference(step.global_T_vehicle.mean, truth_at(mission, step.time_s));
      online_errors.push_back(error.head<2>().norm());
      online_nees += normalized_squared_error(error, step.global_T_vehicle.covariance);
      ++online_count;
    }
  }
  const auto last = std::chrono::steady_clock::now();
  take(pipeline.finish());
  result.global_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - last).count();
  result.total_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.local_s = result.total_s - result.global_s - result.association_s;
  if (online_count > 0) {
    result.online_nees_mean = online_nees / online_count;
    for (const double error : online_errors) {
      result.online_mean_m += error / online_count;
      result.online_max_m = std::max(result.online_max_m, error);
    }
  }

  const WorldEstimate world = pipeline.world(BaseCovariance::kJoint);
  result.submaps = static_cast<int>(pipeline.submaps().size());
  result.live_maps = static_cast<int>(world.maps.size());
  result.landmarks = static_cast<int>(world.landmarks.size());
  Eigen::Matrix2Xd estimated(2, result.landmarks);
  std::vector<std::optional<std::int64_t>> ids;
  for (int i = 0; i < result.landmarks; ++i) {
    const LandmarkEstimate& landmark = world.landmarks[static_cast<std::size_t>(i)];
    estimated.col(i) = landmark.position.mean;
    ids.push_back(landmark.landmark.source_id);
  }
  MapErrorConfig map_config;
  map_config.max_distance_m = 1000.0;
  if (const auto map = map_error(estimated, ids, mission.world.landmarks_m, mission.world.ids, map_config)) {
    result.map_mean_m = map->mean_m;
    result.map_max_m = map->max_m;
  }
  map_config.align = true;
  if (const auto map = map_error(estimated, ids, mission.world.landmarks_m, mission.world.ids, map_config))
    result.aligned_mean_m = map->mean_m;

  // Bases 1.. against the truth at the borders; base 0 is the world frame itself.
  const auto bases = static_cast<Eigen::Index>(world.global_T_base.size());
  Eigen::VectorXd error(3 * (bases - 1));
  Se2 previous_truth;
  for (Eigen::Index k = 1; k < bases; ++k) {
    const Submap& submap = pipeline.submaps()[static_cast<std::size_t>(k - 1)];
    const Se2 truth = truth_at(mission, submap.end_time_s);
    error.segment<3>(3 * (k - 1)) = additive_difference(world.global_T_base[static_cast<std::size_t>(k)], truth);
    result.base_nees.push_back(normalized_squared_error(error.segment<3>(3 * (k - 1)), base_covariance(world, k)));
    result.base_nees_mean += result.base_nees.back() / static_cast<double>(bases - 1);
    const Se2 link_truth = previous_truth.inverse() * truth;
    result.link_nees.push_back(normalized_squared_error(additive_difference(submap.state.vehicle().mean, link_truth),
                                                        submap.state.vehicle().covariance + 1e-12 * Eigen::Matrix3d::Identity()));
    previous_truth = truth;
  }
  result.joint_nees_per_dof = std::numeric_limits<double>::quiet_NaN();  // not every method knows it
  if (world.base_covariance.size() > 0)
    result.joint_nees_per_dof = normalized_squared_error(error, world.base_covariance.bottomRightCorner(error.size(), error.size())) /
                                static_cast<double>(error.size());
  const std::vector<TrajectoryPoint> trajectory = pipeline.trajectory();
  int counted = 0;
  for (std::size_t i = 0; i < trajectory.size(); i += 97) {
    const Eigen::Matrix3d& P = trajectory[i].global_T_vehicle.covariance;
    if (!(P.determinant() > 1e-18)) continue;
    result.trajectory_nees_mean +=
        normalized_squared_error(additive_difference(trajectory[i].global_T_vehicle.mean, truth_at(mission, trajectory[i].time_s)), P);
    ++counted;
  }
  result.trajectory_nees_mean /= std::max(counted, 1);
  result.final_m =
      (trajectory.back().global_T_vehicle.mean.translation() - truth_at(mission, trajectory.back().time_s).translation()).norm();
  result.dead_reckoning_final_m =
      (pipeline.dead_reckoning().translation() - truth_at(mission, trajectory.back().time_s).translation()).norm();
  return result;
}

}  // namespace ssjs::testing
