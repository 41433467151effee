/// A whole log through the pipeline, with everything that the result files hold.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/progress.hpp"
#include "ssjs/pipeline/mission_smoothing.hpp"
#include "ssjs/pipeline/slam_pipeline.hpp"

namespace ssjs {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// One row an event unless said otherwise. Poses are x m, y m, heading rad in the world frame; covariances the row-major upper
/// triangle (6 numbers) of the additive coordinates.
struct MissionResult {
  Eigen::VectorXd time_s;
  RowMatrix pose, covariance;                ///< the final trajectory, smoothed where that is asked for
  RowMatrix online_pose, online_covariance;  ///< what a pilot would have seen at the time
  RowMatrix dead_reckoning;
  std::vector<std::int64_t> submap;
  Eigen::VectorXd step_time_us;

  struct Update {
    double time_s;
    double nis;
    int dof;
  };
  std::vector<Update> updates;  ///< one a scan update
  std::vector<LoopAttempt> loops;
  std::vector<Submap> submaps;  ///< without their steps
  WorldEstimate world;          ///< its landmarks smoothed where that is asked for; its bases as joined

  int observations = 0;  ///< landmark observations used or tried
  int scan_wrong_pairs = 0;
  int loop_candidates = 0, loop_closures = 0, map_wrong_pairs = 0;
  int fusions = 0;                    ///< maps merged: neighbours joined, or loops closed by fusing
  bool map_identities_known = false;  ///< at least one accepted pairing of maps could be checked
  int budget_exhausted = 0;           ///< searches stopped by their node budget
  double fusion_chi_squared = 0.0;    ///< summed over the fusions
  int fusion_dof = 0;
  std::optional<SmoothingReport> smoothing;

  double time_total_s = 0.0, time_local_s = 0.0, time_global_s = 0.0, time_association_s = 0.0, time_smoothing_s = 0.0;
};

/// Events in the order of time. `progress` is asked every thousandth of the log and every tenth of a second, but never
/// within a step, and before what follows the last one; a refusal throws Cancelled.
[[nodiscard]] MissionResult run_mission(const SlamConfig& config, const std::vector<Event>& events, std::uint64_t seed,
                                        const ProgressSink& progress = {});

}  // namespace ssjs
