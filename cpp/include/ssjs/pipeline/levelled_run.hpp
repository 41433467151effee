/// A whole log of an underwater vehicle through the pipeline, with everything that the result files hold.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ssjs/base/progress.hpp"
#include "ssjs/pipeline/levelled_pipeline.hpp"
#include "ssjs/pipeline/mission_run.hpp"

namespace ssjs {

/// Poses are x, y, depth (m), roll, pitch, yaw (rad) in the world frame; covariances the row-major upper triangle (21 numbers). One row a
/// remembered step (trajectory_interval_s) unless said otherwise.
struct LevelledResult {
  Eigen::VectorXd time_s;
  RowMatrix pose, covariance;                ///< the final trajectory
  RowMatrix online_pose, online_covariance;  ///< what a pilot would have seen at the time
  RowMatrix dead_reckoning;
  std::vector<std::int64_t> submap;
  Eigen::VectorXd tick_time_s, step_time_us;  ///< one a tick

  std::vector<MissionResult::Update> updates;  ///< one a tick with samples that were used
  std::vector<FrameSighting> frame_sightings;  ///< ascending time
  std::vector<LoopAttempt> loops;
  std::vector<FixAttempt> fixes;
  std::vector<LevelledSubmap> submaps;  ///< without their steps
  std::vector<GaussianSe2> global_T_base;
  Eigen::MatrixXd base_covariance;        ///< of all bases, 3 each; empty in a long mission
  std::vector<SurveyLandmark> landmarks;  ///< confirmed ones and others
  Eigen::MatrixXd landmark_covariance;    ///< of all of them, 3 each; empty where there are too many or the method does not know it
  ExistenceModel existence{};             ///< learnt on the way
  std::vector<LiveMapEstimate> live_maps;
  std::array<SensorStatistics, kNavigationSensors> sensors{};

  int ticks = 0, observations = 0, refused = 0, scan_wrong_pairs = 0;
  int loop_candidates = 0, loop_closures = 0, fusions = 0, map_wrong_pairs = 0;
  double fusion_chi_squared = 0.0;  ///< of what was joined, with fusion_dof degrees of freedom
  int fusion_dof = 0;
  bool map_identities_known = false;
  int budget_exhausted = 0;
  int compass_jumps = 0;
  int merged = 0;        ///< landmarks that were known twice
  int unsound_maps = 0;  ///< of which nothing was believed

  double time_total_s = 0.0, time_global_s = 0.0, time_association_s = 0.0;
};

/// Ticks in the order of time; progress as in run_mission().
[[nodiscard]] LevelledResult run_levelled_mission(const LevelledConfig& config, const std::vector<NavigationTick>& ticks,
                                                  const ProgressSink& progress = {}, std::uint64_t seed = 1);

}  // namespace ssjs
