#include "ssjs/sensors/side_scan.hpp"

#include <Eigen/LU>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

double squared(double x) { return x * x; }

/// Body-frame coordinates of a landmark with their derivatives.
struct BodyPoint {
  Eigen::Vector3d p;
  Eigen::Matrix<double, 3, 6> J_pose;
  Eigen::Matrix3d J_landmark;
};

BodyPoint body_point(const VehicleVector& state, const Eigen::Vector3d& map_p_landmark) {
  const Se3 pose = map_T_vehicle(state);
  const Eigen::Matrix3d vehicle_R_map = pose.rotation().transpose();
  return {vehicle_R_map * (map_p_landmark - pose.translation), inverse_act_jacobian(pose, map_p_landmark), vehicle_R_map};
}

Eigen::Matrix3d covariance_of(const VehicleVector& state, const SideScanSighting& sighting, const SideScanConfig& config) {
  if (sighting.covariance) {
    Eigen::Matrix3d covariance = *sighting.covariance;
    if (config.form == SideScanForm::kFlatBottom && sighting.vehicle_p_point.y() < 0.0) {  // the row is the slant range, |y|
      covariance(0, 1) = -covariance(0, 1);
      covariance(1, 0) = -covariance(1, 0);
    }
    return covariance;
  }
  const double range = config.form == SideScanForm::kFlatBottom ? std::abs(sighting.vehicle_p_point.y()) : sighting.vehicle_p_point.norm();
  return side_scan_covariance(range, velocity_of(state).norm(), config);
}

/// The point of the body frame with this x, this slant range and side, at this height below the vehicle; nothing if there is none.
std::optional<Eigen::Vector3d> on_flat_bottom(const Eigen::Vector3d& rpy, double x, double signed_range, double below_m) {
  const double side = signed_range < 0.0 ? -1.0 : 1.0;
  const double across_squared = squared(signed_range) - squared(x);
  if (!(across_squared > 0.0)) return std::nullopt;
  const double across = std::sqrt(across_squared);
  const double sine = (below_m + std::sin(rpy.y()) * x) / (across * std::cos(rpy.y()));
  if (!(std::abs(sine) < 1.0)) return std::nullopt;
  const double depression = std::asin(sine) - side * rpy.x();
  return Eigen::Vector3d(x, side * across * std::cos(depression), across * std::sin(depression));
}

}  // namespace

Eigen::Matrix3d side_scan_covariance(double range_m, double speed_m_s, const SideScanConfig& config) {
  constexpr double kUniform = 1.0 / 12.0;  // variance of a width: pings and beam
  Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
  R(0, 0) = squared(config.along_track_sigma_m) + squared(config.timing_sigma_s * speed_m_s) +
            kUniform * (squared(config.ping_interval_s * speed_m_s) + squared(config.beam_width_rad * range_m));
  R(1, 1) = squared(config.across_sigma_m);
  R(2, 2) = squared(config.height_sigma_m);
  return R;
}

SideScanRows side_scan_rows(const VehicleVector& state, const SideScanSighting& sighting, const Eigen::Vector3d& map_p_landmark,
                            const SideScanConfig& config) {
  if (!sighting.vehicle_p_point.allFinite()) {
    throw InvalidArgument("SideScanSighting.vehicle_p_point", "not finite", "must be finite");
  }
  const BodyPoint body = body_point(state, map_p_landmark);
  const Eigen::Matrix3d covariance = covariance_of(state, sighting, config);
  if (config.form == SideScanForm::kPoint) {
    SideScanRows rows{VehicleRows(3), body.J_landmark};
    rows.vehicle.residual = sighting.vehicle_p_point - body.p;
    rows.vehicle.H.block<3, 6>(0, Layout::kPosition) = body.J_pose;
    rows.vehicle.R = covariance;
    return rows;
  }
  const double range = body.p.norm();
  if (!(range > 1e-6))
    throw InvalidArgument("side_scan_rows range", range, "the landmark must be at least 1e-6 m away: nearer it has no range");
  const Eigen::RowVector3d direction = body.p.transpose() / range;
  SideScanRows rows{VehicleRows(2), Eigen::Matrix<double, 2, 3>::Zero()};
  rows.vehicle.residual << sighting.vehicle_p_point.x() - body.p.x(), std::abs(sighting.vehicle_p_point.y()) - range;
  rows.vehicle.H.block<1, 6>(0, Layout::kPosition) = body.J_pose.row(0);
  rows.vehicle.H.block<1, 6>(1, Layout::kPosition) = direction * body.J_pose;
  rows.vehicle.R = covariance.topLeftCorner<2, 2>();
  rows.H_landmark << body.J_landmark.row(0), direction * body.J_landmark;
  return rows;
}

std::optional<SideScanLandmark> landmark_from_side_scan(const VehicleVector& state, const SideScanSighting& sighting,
                                                        const SideScanConfig& config) {
  const Se3 pose = map_T_vehicle(state);
  const Eigen::Matrix3d covariance = covariance_of(state, sighting, config);
  SideScanLandmark landmark;
  landmark.J_vehicle.setZero();
  if (config.form == SideScanForm::kPoint) {
    const Eigen::Matrix3d R = pose.rotation();
    landmark.map_p_landmark = pose * sighting.vehicle_p_point;
    landmark.J_vehicle.leftCols<6>() = act_jacobian(pose, sighting.vehicle_p_point);
    landmark.noise = R * covariance * R.transpose();
    return landmark;
  }
  const double below_m = state(Layout::kSeabed) - state(Layout::kPosition + 2);
  const std::optional<Eigen::Vector3d> point =
      on_flat_bottom(pose.rpy, sighting.vehicle_p_point.x(), sighting.vehicle_p_point.y(), below_m);
  if (!point) return std::nullopt;
  landmark.map_p_landmark = pose * *point;
  // x, range and depth of the landmark are three functions of state and landmark; their landmark block turned around
  const BodyPoint body = body_point(state, landmark.map_p_landmark);
  const Eigen::RowVector3d direction = body.p.transpose() / body.p.norm();
  Eigen::Matrix3d H_landmark;
  H_landmark << body.J_landmark.row(0), direction * body.J_landmark, Eigen::RowVector3d::UnitZ();
  Eigen::Matrix<double, 3, Layout::kSize> H_state = Eigen::Matrix<double, 3, Layout::kSize>::Zero();
  H_state.block<1, 6>(0, Layout::kPosition) = body.J_pose.row(0);
  H_state.block<1, 6>(1, Layout::kPosition) = direction * body.J_pose;
  H_state(2, Layout::kSeabed) = -1.0;
  const Eigen::Matrix3d inverse = H_landmark.inverse();
  Eigen::Matrix3d noise = covariance;
  noise.row(2).setZero();
  noise.col(2).setZero();
  noise(2, 2) = squared(config.flat_bottom_sigma_m);
  landmark.J_vehicle = -inverse * H_state;
  landmark.noise = inverse * noise * inverse.transpose();
  return landmark;
}

}  // namespace ssjs
