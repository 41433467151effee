#include "ssjs/evaluation/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_alignment.hpp"

namespace ssjs {
namespace {

void check_times(const std::vector<double>& time_s, const std::string& name) {
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const std::string entry = name + "[" + std::to_string(i) + "]";
    if (!std::isfinite(time_s[i])) throw InvalidArgument(entry, time_s[i], "must be finite");
    if (i > 0 && time_s[i] < time_s[i - 1]) throw InvalidArgument(entry, time_s[i], "times must not decrease");
  }
}

void check(const Trajectory& estimate, const ReferenceFixes& reference, const TrajectoryErrorConfig& config) {
  check_times(estimate.time_s, "Trajectory.time_s");
  check_times(reference.time_s, "ReferenceFixes.time_s");
  const std::size_t fixes = reference.time_s.size();
  if (estimate.global_T_vehicle.size() != estimate.time_s.size()) {
    throw InvalidArgument("Trajectory.global_T_vehicle", std::to_string(estimate.global_T_vehicle.size()) + " poses",
                          "must have one per time (" + std::to_string(estimate.time_s.size()) + ")");
  }
  if (static_cast<std::size_t>(reference.position_m.cols()) != fixes) {
    throw InvalidArgument("ReferenceFixes.position_m", std::to_string(reference.position_m.cols()) + " columns",
                          "must have one per time (" + std::to_string(fixes) + ")");
  }
  if (reference.heading_rad && static_cast<std::size_t>(reference.heading_rad->size()) != fixes) {
    throw InvalidArgument("ReferenceFixes.heading_rad", std::to_string(reference.heading_rad->size()) + " values",
                          "must have one per time (" + std::to_string(fixes) + ")");
  }
  if (!reference.position_m.allFinite() || (reference.heading_rad && !reference.heading_rad->allFinite()) ||
      !reference.vehicle_p_antenna.allFinite()) {
    throw InvalidArgument("ReferenceFixes", "NaN or infinity", "every value must be finite; leave out the fixes that are not");
  }
  for (std::size_t i = 0; i < estimate.global_T_vehicle.size(); ++i) {
    if (!estimate.global_T_vehicle[i].vector().allFinite()) {
      throw InvalidArgument("Trajectory.global_T_vehicle[" + std::to_string(i) + "]", "NaN or infinity", "every pose must be finite");
    }
  }
  if (config.outlier_m && !(*config.outlier_m > 0.0)) {
    throw InvalidArgument("TrajectoryErrorConfig.outlier_m", *config.outlier_m, "must be positive, or absent");
  }
  if (!(config.max_gap_s >= 0.0)) throw InvalidArgument("TrajectoryErrorConfig.max_gap_s", config.max_gap_s, "must be zero or positive");
}

/// (E-1) The estimate at time t; empty outside its span and too far from its neighbours.
std::optional<Se2> interpolate(const Trajectory& estimate, double t, double max_gap_s) {
  constexpr double kSameTimeSeconds = 1e-6;  // clocks written as text round
  const std::vector<double>& times = estimate.time_s;
  const auto next = std::upper_bound(times.begin(), times.end(), t);
  const std::size_t after = static_cast<std::size_t>(next - times.begin());
  if (next == times.end()) {
    if (times.empty() || t - times.back() > kSameTimeSeconds) return std::nullopt;
    return estimate.global_T_vehicle.back();
  }
  if (next == times.begin()) {
    if (*next - t > kSameTimeSeconds) return std::nullopt;
    return estimate.global_T_vehicle.front();
  }
  const double before_s = t - times[after - 1];
  const double after_s = times[after] - t;
  if (std::min(before_s, after_s) > max_gap_s) return std::nullopt;
  const Se2& left = estimate.global_T_vehicle[after - 1];
  const Se2& right = estimate.global_T_vehicle[after];
  return additive_step(left, before_s / (before_s + after_s) * additive_difference(right, left));
}

/// The fixes that can be compared, one column or entry each.
struct Compared {
  std::vector<double> time_s;
  std::vector<Se2> estimate;
  Eigen::Matrix2Xd estimate_m;  ///< antenna of the estimate
  Eigen::Matrix2Xd reference_m;
  std::optional<Eigen::VectorXd> heading_rad;
  [[nodiscard]] Eigen::Index size() const { return reference_m.cols(); }
};

Compared compare(const Trajectory& estimate, const ReferenceFixes& reference, double max_gap_s) {
  Compared compared;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < reference.time_s.size(); ++i) {
    const std::optional<Se2> pose = interpolate(estimate, reference.time_s[i], max_gap_s);
    if (!pose) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    compared.time_s.push_back(reference.time_s[i]);
    compared.estimate.push_back(*pose);
  }
  const Eigen::Index n = static_cast<Eigen::Index>(kept.size());
  compared.estimate_m.resize(2, n);
  compared.reference_m.resize(2, n);
  if (reference.heading_rad) compared.heading_rad = Eigen::VectorXd(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = kept[static_cast<std::size_t>(k)];
    compared.estimate_m.col(k) = compared.estimate[static_cast<std::size_t>(k)] * reference.vehicle_p_antenna;
    compared.reference_m.col(k) = reference.position_m.col(i);
    if (reference.heading_rad) (*compared.heading_rad)(k) = (*reference.heading_rad)(i);
  }
  return compared;
}

/// The rotation that the reference's headings ask for (mean direction over `inlier`); zero where it has none.
double heading_offset(const Compared& compared, const Eigen::VectorXd& inlier) {
  if (!compared.heading_rad) return 0.0;
  double cosine = 0.0;
  double sine = 0.0;
  for (Eigen::Index k = 0; k < compared.size(); ++k) {
    const double offset = (*compared.heading_rad)(k)-compared.estimate[static_cast<std::size_t>(k)].heading;
    cosine += inlier(k) * std::cos(offset);
    sine += inlier(k) * std::sin(offset);
  }
  return wrap_angle(std::atan2(sine, cosine));
}

/// The motion with this heading that takes estimate_m to reference_m.
Se2 motion_through(double heading, const Eigen::Vector2d& estimate_m, const Eigen::Vector2d& reference_m) {
  const Se2 turn{0.0, 0.0, heading};
  const Eigen::Vector2d shift = reference_m - turn * estimate_m;
  return {shift.x(), shift.y(), heading};
}

/// (E-3) inlier: one weight per compared fix, 1 or 0.
Se2 align(const Compared& compared, Alignment alignment, const Eigen::VectorXd& inlier) {
  if (alignment == Alignment::kNone) return {};
  if (alignment == Alignment::kOrigin) {
    const Eigen::VectorXd first = Eigen::VectorXd::Unit(compared.size(), 0);
    return motion_through(heading_offset(compared, first), compared.estimate_m.col(0), compared.reference_m.col(0));
  }
  if (const std::optional<Se2> motion = align_points(compared.reference_m, compared.estimate_m, inlier)) return *motion;
  // a vehicle that stood still has no direction: its headings give the rotation, where the reference has them
  const double total = inlier.sum();
  return motion_through(heading_offset(compared, inlier), compared.estimate_m * inlier / total, compared.reference_m * inlier / total);
}

std::vector<double> position_errors(const Compared& compared, const Se2& reference_T_estimate) {
  std::vector<double> errors(static_cast<std::size_t>(compared.size()));
  for (Eigen::Index k = 0; k < compared.size(); ++k) {
    const Eigen::Vector2d moved = reference_T_estimate * Eigen::Vector2d(compared.estimate_m.col(k));
    errors[static_cast<std::size_t>(k)] = (compared.reference_m.col(k) - moved).norm();  // (E-2)
  }
  return errors;
}

double median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(middle), values.end());
  const double upper = values[middle];
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(middle)));
}

Eigen::VectorXd within(const std::vector<double>& errors, double limit) {
  Eigen::VectorXd inlier(static_cast<Eigen::Index>(errors.size()));
  for (std::size_t k = 0; k < errors.size(); ++k) inlier(static_cast<Eigen::Index>(k)) = errors[k] <= limit ? 1.0 : 0.0;
  return inlier;
}

/// (E-4) The fixes that count: gross errors bend the first alignment, so the limit starts at three medians and comes down to outlier_m.
Eigen::VectorXd find_inliers(const Compared& compared, const TrajectoryErrorConfig& config) {
  Eigen::VectorXd inlier = Eigen::VectorXd::Ones(compared.size());
  if (!config.outlier_m) return inlier;
  constexpr int kMaxRounds = 100;
  bool final_limit = false;
  for (int round = 0; round < kMaxRounds && inlier.sum() > 0.0; ++round) {
    const std::vector<double> errors = position_errors(compared, align(compared, config.alignment, inlier));
    const double limit = final_limit ? *config.outlier_m : std::max(*config.outlier_m, 3.0 * median(errors));
    const Eigen::VectorXd repeated = within(errors, limit);
    const bool stable = repeated == inlier;
    if (stable && limit == *config.outlier_m) break;
    final_limit = final_limit || stable;
    inlier = repeated;
  }
  return inlier;
}

}  // namespace

std::optional<TrajectoryError> trajectory_error(const Trajectory& estimate, const ReferenceFixes& reference,
                                                const TrajectoryErrorConfig& config) {
  check(estimate, reference, config);
  const Compared compared = compare(estimate, reference, config.max_gap_s);
  if (compared.size() == 0) return std::nullopt;
  const Eigen::VectorXd inlier = find_inliers(compared, config);
  if (!(inlier.sum() > 0.0)) return std::nullopt;

  TrajectoryError result;
  result.reference_T_estimate = align(compared, config.alignment, inlier);
  result.time_s = compared.time_s;
  result.error_m = position_errors(compared, result.reference_T_estimate);
  result.compared = static_cast<int>(compared.size());

  // (E-5) statistics of the inliers
  std::vector<double> errors;
  double sum = 0.0;
  double square_sum = 0.0;
  double heading_square_sum = 0.0;
  std::optional<Eigen::Index> previous;
  for (Eigen::Index k = 0; k < compared.size(); ++k) {
    const bool counts = inlier(k) > 0.0;
    result.is_outlier.push_back(!counts);
    if (!counts) continue;
    const double error = result.error_m[static_cast<std::size_t>(k)];
    errors.push_back(error);
    sum += error;
    square_sum += error * error;
    result.max_m = std::max(result.max_m, error);
    result.final_error_m = error;
    if (compared.heading_rad) {
      const double predicted = result.reference_T_estimate.heading + compared.estimate[static_cast<std::size_t>(k)].heading;
      const double residual = angle_difference((*compared.heading_rad)(k), predicted);
      heading_square_sum += residual * residual;
    }
    if (previous) result.path_length_m += (compared.reference_m.col(k) - compared.reference_m.col(*previous)).norm();
    previous = k;
  }
  const double n = static_cast<double>(errors.size());
  result.outliers = result.compared - static_cast<int>(errors.size());
  result.mean_m = sum / n;
  result.rmse_m = std::sqrt(square_sum / n);
  double deviation_sum = 0.0;
  for (const double error : errors) deviation_sum += (error - result.mean_m) * (error - result.mean_m);
  result.std_m = std::sqrt(deviation_sum / n);
  result.median_m = median(errors);
  if (compared.heading_rad) result.heading_rmse_rad = std::sqrt(heading_square_sum / n);
  if (result.path_length_m > 0.0) result.final_drift_percent = 100.0 * result.final_error_m / result.path_length_m;
  return result;
}

}  // namespace ssjs
