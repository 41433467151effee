#include "ssjs/joining/unsound_map.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr double kShortest_s = 10.0;        // a map that took no time still may have gone somewhere
constexpr double kUnknownOffsetRad = 10.0;  // as of a map without a compass reading
constexpr double kUnknownDepth_m = 100.0;   // sigma
constexpr double kUnknownTilt_rad = 0.5;    // sigma
constexpr double kFarthest_m = 1e6;         // a mean beyond is no place

double squared(double x) { return x * x; }

}  // namespace

bool is_sound(const LevelledSubmap& submap) {
  if (!submap.mean.allFinite() || !submap.covariance.allFinite()) return false;
  return submap.covariance.selfadjointView<Eigen::Lower>().llt().info() == Eigen::Success;
}

LevelledSubmap without_knowledge(const LevelledSubmap& submap) {
  LevelledSubmap blank;
  blank.index = submap.index;
  blank.start_time_s = submap.start_time_s;
  blank.end_time_s = submap.end_time_s;
  blank.closed_because = submap.closed_because;
  blank.compass = submap.compass;
  const Eigen::Index n = 3 + submap.compass_rows();
  const Eigen::VectorXd said = submap.mean.head(n);
  const bool is_place = said.allFinite() && said.head<2>().cwiseAbs().maxCoeff() < kFarthest_m;
  blank.mean = is_place ? said : Eigen::VectorXd::Zero(n);
  const double way_m = kFastestVehicle_m_s * std::max(kShortest_s, submap.end_time_s - submap.start_time_s);
  Eigen::VectorXd variances = Eigen::VectorXd::Constant(n, squared(kUnknownOffsetRad));
  variances.head<3>() << squared(way_m), squared(way_m), kPi * kPi / 3.0;  // any heading
  blank.covariance = variances.asDiagonal();
  if (submap.compass_mean) blank.compass_mean = CompassMean{0.0, squared(kUnknownOffsetRad), submap.compass_mean->time_s};
  Vector6d step_variances;
  step_variances << squared(way_m), squared(way_m), squared(kUnknownDepth_m), squared(kUnknownTilt_rad), squared(kUnknownTilt_rad),
      kPi * kPi / 3.0;
  for (const LevelledStep& step : submap.steps) {
    LevelledStep unsure;
    unsure.time_s = step.time_s;
    if (step.base_T_vehicle.allFinite() && step.base_T_vehicle.head<3>().cwiseAbs().maxCoeff() < kFarthest_m)
      unsure.base_T_vehicle = step.base_T_vehicle;
    unsure.covariance = step_variances.asDiagonal();
    unsure.gain = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, 3);
    unsure.conditional_covariance = unsure.covariance;
    blank.steps.push_back(unsure);
  }
  return blank;
}

}  // namespace ssjs
