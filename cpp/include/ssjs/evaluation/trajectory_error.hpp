/// Errors of a trajectory against a reference that may be sparse. docs/math/evaluation.md (E-1..E-5).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

enum class Alignment { kNone, kOrigin, kYaw, kSe2 };
// In the plane kYaw and kSe2 are the same motion (x, y, heading); both names are accepted.

/// A stamped trajectory; times non-decreasing.
struct Trajectory {
  std::vector<double> time_s;
  std::vector<Se2> global_T_vehicle;
};

/// Position fixes, with heading where the reference has one.
struct ReferenceFixes {
  std::vector<double> time_s;
  Eigen::Matrix2Xd position_m;
  std::optional<Eigen::VectorXd> heading_rad;
  Eigen::Vector2d vehicle_p_antenna = Eigen::Vector2d::Zero();  ///< lever arm: the fix is of this point of the vehicle
};

struct TrajectoryErrorConfig {
  Alignment alignment = Alignment::kSe2;
  std::optional<double> outlier_m;  ///< fixes with a larger error after alignment are rejected, and counted
  double max_gap_s = 1.0;  ///< fixes farther in time from both neighbouring estimates are not compared, nor any outside the estimate's span
};

struct TrajectoryError {
  int compared = 0;  ///< outliers included
  int outliers = 0;  ///< left out of every statistic below
  double rmse_m = 0.0, mean_m = 0.0, std_m = 0.0, max_m = 0.0, median_m = 0.0;
  std::optional<double> heading_rmse_rad;
  double final_error_m = 0.0;        ///< at the last fix that is no outlier
  double path_length_m = 0.0;        ///< of the reference over the fixes that are no outliers
  double final_drift_percent = 0.0;  ///< 100 * final_error_m / path_length_m; 0 for a path of no length
  Se2 reference_T_estimate;          ///< the alignment applied to the estimate
  std::vector<double> time_s;        ///< per compared fix (outliers included, flagged)
  std::vector<double> error_m;
  std::vector<bool> is_outlier;
};

/// Interpolates the estimate at the reference times (heading along the shorter arc), aligns it to the reference by least squares
/// with outliers rejected and the alignment repeated until the set is stable, and measures. A straight track aligns (its heading
/// comes from the track's direction); a vehicle that stood still takes its rotation from the reference's headings, or keeps its own.
/// kOrigin holds the first fix, and its heading where there is one. Empty when no fix can be compared or all are outliers.
[[nodiscard]] std::optional<TrajectoryError> trajectory_error(const Trajectory& estimate, const ReferenceFixes& reference,
                                                              const TrajectoryErrorConfig& config);

}  // namespace ssjs
