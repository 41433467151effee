/// A simulated survey close to a seabed full of points, seen by a camera that looks down.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "mapping/survey_run.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/sensors/pinhole.hpp"

namespace ssjs::testing {

struct CameraMission {
  AuvSimulationConfig simulation;
  CameraConfig camera;
  std::vector<Eigen::Vector2d> waypoints{{0.0, 0.0}, {20.0, 0.0}};
  double seabed_m = 14.5;
  double points_per_m2 = 4.0;
  double margin_m = 6.0;           ///< of the points about the waypoints
  int steps_per_frame = 3;         ///< of the simulation's 0.1 s
  double detection = 0.8;          ///< probability that a frame shows a point that lies in it
  int clutter = 0;                 ///< keypoints of nothing in each frame
  double descriptor_noise = 0.02;  ///< of each of its 64 numbers, unit length in all
};

/// Half a metre a second, 2.5 m over the seabed; three frames a second of 320 x 240 pixels.
inline CameraMission camera_mission() {
  CameraMission mission;
  AuvSimulationConfig& vehicle = mission.simulation;
  vehicle.speed_m_s = 0.5;
  vehicle.depth_m = 12.0;
  vehicle.lookahead_m = 5.0;
  vehicle.velocity_gap_s = 0.0;
  vehicle.velocity_time_constant_s = vehicle.seabed_time_constant_s = 1e6;  // random walks, as the filter has them
  vehicle.motion.seabed_walk_m_sqrt_s = 0.005;
  CameraConfig& camera = mission.camera;
  camera.width_px = 320;
  camera.height_px = 240;
  camera.fx_px = camera.fy_px = 280.0;
  camera.cx_px = 159.5;
  camera.cy_px = 119.5;
  camera.relief = 0.1;
  return mission;
}

struct CameraSurvey {
  SimulatedSurvey survey;
  Eigen::MatrixXf descriptors;  ///< 64 x points
};

inline VehicleVector state_in_world(const AuvTruth& truth) {
  VehicleVector x = VehicleVector::Zero();
  x.head<6>() = truth.world_T_vehicle.vector();
  x(VehicleLayout::kSeabed) = truth.seabed_m;
  return x;
}

inline Descriptor unit_descriptor(Rng& rng) {
  Descriptor descriptor(64);
  for (Eigen::Index i = 0; i < descriptor.size(); ++i) descriptor(i) = static_cast<float>(rng.normal());
  return descriptor.normalized();
}

inline CameraSighting clutter_sighting(const PinholeCamera& camera, Rng& rng) {
  CameraSighting nothing;
  nothing.pixel << rng.uniform(0.0, camera.width_px), rng.uniform(0.0, camera.height_px);
  nothing.descriptor = unit_descriptor(rng);
  return nothing;
}

/// What the frame at this truth shows.
inline CameraFrame frame_at(const AuvTruth& truth, const CameraSurvey& made, const CameraMission& mission, Rng& rng) {
  const PinholeCamera camera = *pinhole_camera(mission.camera);
  const VehicleVector x = state_in_world(truth);
  CameraFrame frame;
  for (Eigen::Index i = 0; i < made.survey.world.landmarks_m.cols(); ++i) {
    const Eigen::Vector3d point = made.survey.world.landmarks_m.col(i);
    if ((point - x.head<3>()).norm() > 8.0) continue;
    const auto seen = predict_pixel(x, point, camera, mission.camera);
    if (!seen || seen->pixel.minCoeff() < 0.0 || seen->pixel.x() >= camera.width_px || seen->pixel.y() >= camera.height_px) continue;
    if (rng.uniform(0.0, 1.0) > mission.detection) continue;
    CameraSighting& sighting = frame.sightings.emplace_back();
    sighting.pixel = seen->pixel + mission.camera.sigma_px * Eigen::Vector2d(rng.normal(), rng.normal());
    sighting.landmark_id = i;
    sighting.descriptor = made.descriptors.col(i);
    for (Eigen::Index k = 0; k < sighting.descriptor.size(); ++k) {
      sighting.descriptor(k) += static_cast<float>(rng.normal(mission.descriptor_noise));
    }
  }
  for (int i = 0; i < mission.clutter; ++i) frame.sightings.push_back(clutter_sighting(camera, rng));
  return frame;
}

inline CameraSurvey simulate_camera(const CameraMission& mission, std::uint64_t seed) {
  Rng rng = Rng(seed).stream("camera");
  Eigen::Vector2d low = mission.waypoints.front(), high = low;
  for (const Eigen::Vector2d& point : mission.waypoints) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  low.array() -= mission.margin_m;
  high.array() += mission.margin_m;
  SurveyWorld world;
  world.waypoints = mission.waypoints;
  const auto count = static_cast<Eigen::Index>(std::lround(mission.points_per_m2 * (high - low).prod()));
  world.landmarks_m.resize(3, count);
  const double sigma_m = mission.camera.relief * (mission.seabed_m - mission.simulation.depth_m);
  for (Eigen::Index i = 0; i < count; ++i) {
    world.landmarks_m.col(i) << rng.uniform(low.x(), high.x()), rng.uniform(low.y(), high.y()), mission.seabed_m + rng.normal(sigma_m);
    world.ids.push_back(i);
  }
  CameraSurvey made{simulate_survey(world, mission.simulation, seed), Eigen::MatrixXf(64, count)};
  for (Eigen::Index i = 0; i < count; ++i) made.descriptors.col(i) = unit_descriptor(rng);
  for (std::size_t i = 0; i < made.survey.ticks.size(); ++i) {
    made.survey.ticks[i].sightings.clear();  // there is no sonar
    if (i % static_cast<std::size_t>(mission.steps_per_frame) == 0) {
      made.survey.ticks[i].frame = frame_at(made.survey.truth[i], made, mission, rng);
    }
  }
  return made;
}

/// The builder that has the models and noises of the mission.
inline LevelledBuilderConfig matched(const CameraMission& mission) {
  LevelledBuilderConfig config = matched(mission.simulation);
  config.start.speed_m_s = mission.simulation.speed_m_s;
  config.start.altitude_m = mission.seabed_m - mission.simulation.depth_m;
  config.camera = mission.camera;
  return config;
}

}  // namespace ssjs::testing
