/// A simulated survey through the builder of levelled maps, beside its truth.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs::testing {

/// The filter that has the simulator's models and noises.
inline LevelledBuilderConfig matched(const AuvSimulationConfig& simulation) {
  LevelledBuilderConfig config;
  config.motion = simulation.motion;
  config.attitude = simulation.attitude;
  config.compass = simulation.compass;
  config.depth = simulation.depth;
  config.altitude = simulation.altitude;
  config.velocity_log = simulation.velocity_log;
  config.side_scan = simulation.side_scan;
  config.association.method = AssociationMethod::kKnown;
  return config;
}

inline void never_split(LevelledBuilderConfig& config) {
  config.split.policy = {std::nullopt, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 2};
  config.split.longest_m = 1e9;
}

/// Maps of this length, whatever they hold.
inline void split_every(LevelledBuilderConfig& config, double length_m) {
  config.split.policy = {std::nullopt, std::nullopt, std::nullopt, length_m, std::nullopt, 0};
  config.split.longest_m = length_m;
}

inline Se2 level_pose(const AuvTruth& truth) {
  const Se3& pose = truth.world_T_vehicle;
  return {pose.translation.x(), pose.translation.y(), pose.rpy.z()};
}

/// The true state in a map that started at `start`.
inline VehicleVector true_vehicle(const AuvTruth& now, const AuvTruth& start) {
  const Se2 base_T_vehicle = level_pose(start).inverse() * level_pose(now);
  VehicleVector x = VehicleVector::Zero();
  x.head<15>() << base_T_vehicle.x, base_T_vehicle.y, now.world_T_vehicle.translation.z(), now.world_T_vehicle.rpy.x(),
      now.world_T_vehicle.rpy.y(), base_T_vehicle.heading, now.velocity_m_s, now.seabed_m,
      wrap_angle(now.compass_offset_rad + start.world_T_vehicle.rpy.z()),
      wrap_angle(start.compass_offset_rad + start.world_T_vehicle.rpy.z()), now.rates_rad_s;
  return x;
}

/// truth - estimate, the angles wrapped.
inline VehicleVector vehicle_error(const VehicleVector& truth, const VehicleVector& estimate) {
  VehicleVector error = truth - estimate;
  wrap_vehicle(error);
  return error;
}

inline const AuvTruth& truth_at(const SimulatedSurvey& survey, double time_s) {
  const double step_s = survey.truth[1].time_s - survey.truth[0].time_s;
  return survey.truth[static_cast<std::size_t>(std::lround(time_s / step_s))];
}

/// The true values of a map's state, in its order, and their difference to its mean.
inline Eigen::VectorXd map_error(const LevelledSubmap& map, const SimulatedSurvey& survey) {
  const AuvTruth& start = truth_at(survey, map.start_time_s);
  const VehicleVector end = true_vehicle(truth_at(survey, map.end_time_s), start);
  Eigen::VectorXd truth(map.mean.size());
  truth.head<3>() << end(0), end(1), end(5);
  if (map.compass == CompassPorts::kBorders) truth.segment<2>(3) << end(11), end(10);
  if (map.compass == CompassPorts::kConstant) truth(3) = end(10);
  const Se2 base_T_world = level_pose(start).inverse();
  for (Eigen::Index i = 0; i < map.landmark_count(); ++i) {
    const Eigen::Vector3d p =
        survey.world.landmarks_m.col(static_cast<Eigen::Index>(*map.landmarks[static_cast<std::size_t>(i)].source_id));
    truth.segment<2>(map.landmark_offset(i)) = base_T_world * Eigen::Vector2d(p.head<2>());
    truth(map.landmark_offset(i) + 2) = p.z();
  }
  Eigen::VectorXd error = truth - map.mean;
  for (Eigen::Index i = 2; i < 3 + map.compass_rows(); ++i) error(i) = wrap_angle(error(i));
  return error;
}

inline double nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, Eigen::Index n) {
  return normalized_squared_error(error.head(n), covariance.topLeftCorner(n, n));
}

inline std::vector<LevelledSubmap> build_maps(const SimulatedSurvey& survey, const LevelledBuilderConfig& config) {
  LevelledBuilder builder(config);
  std::vector<LevelledSubmap> maps;
  for (const NavigationTick& tick : survey.ticks) {
    TickResult result = builder.feed(tick);
    if (result.closed) maps.push_back(std::move(*result.closed));
  }
  maps.push_back(*builder.finish("end"));
  return maps;
}

}  // namespace ssjs::testing
