/// From the events of a mission and what its run made of them to the least-squares problem, and from its solution back to a trajectory and
/// a map. docs/math/smoothing.md (B-11..B-14).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/features/event.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/mapping/submap_builder.hpp"
#include "ssjs/pipeline/final_trajectory.hpp"
#include "ssjs/pipeline/motion.hpp"
#include "ssjs/pipeline/slam_config.hpp"
#include "ssjs/pipeline/smoother.hpp"

namespace ssjs {

struct SmoothedMission {
  SmoothingReport report;
  std::vector<TrajectoryPoint> trajectory;  ///< one point an event
  std::vector<LandmarkEstimate> landmarks;
};

/// Fed with the same events as the pipeline, while it runs. A pose of the problem is the vehicle where the mission begins, at every
/// observation that the run used, and at every increment.
class MissionSmoothing {
 public:
  explicit MissionSmoothing(const SlamConfig& config);

  /// An event that the pipeline has taken, and what its scan did.
  void feed(const Event& event, const std::optional<ScanResult>& scan);

  /// The problem of all events fed so far, started from the run's own answer: one point of the trajectory an event. Landmarks that known
  /// identities say are one are listed once.
  [[nodiscard]] SmoothingProblem problem(const std::vector<TrajectoryPoint>& trajectory, std::vector<LandmarkEstimate>& landmarks) const;

  [[nodiscard]] SmoothedMission smooth(const std::vector<TrajectoryPoint>& trajectory, std::vector<LandmarkEstimate> landmarks) const;

 private:
  struct Sighting {
    int pose;
    UsedObservation observation;
  };
  void begin_pose();
  [[nodiscard]] std::vector<TrajectoryPoint> between(const Smoother& smoother, const std::vector<TrajectoryPoint>& before) const;

  SlamConfig config_;
  OdometryMotion motion_;
  GaussianSe2 pose_T_vehicle_;                ///< since the last pose of the problem
  std::vector<SubmapStep> steps_;             ///< one an event; base: the last pose of the problem, exit: the next one
  std::vector<Eigen::Matrix3d> transitions_;  ///< F of every step
  std::vector<std::size_t> first_step_{0};    ///< of every pose
  std::vector<MotionFactor> motions_;         ///< number k leads from pose k to pose k + 1
  std::vector<Sighting> sightings_;
};

}  // namespace ssjs
