#include "ssjs/sensors/side_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "sensors/random_vehicle.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_vehicle;

SideScanSighting sighting_of(double x, double y, double z) {
  SideScanSighting sighting;
  sighting.vehicle_p_point = {x, y, z};
  sighting.covariance = Eigen::Vector3d(0.09, 0.04, 0.09).asDiagonal();
  return sighting;
}

TEST(SideScan, A11_A13_JacobiansOfAReSighting) {
  Rng rng(61);
  for (const SideScanForm form : {SideScanForm::kPoint, SideScanForm::kFlatBottom}) {
    SideScanConfig config;
    config.form = form;
    for (int point = 0; point < kJacobianPoints; ++point) {
      const VehicleVector x = random_vehicle(rng, point);
      const Eigen::Vector3d landmark(rng.uniform(-30, 30), rng.uniform(-30, 30), rng.uniform(20, 30));
      const SideScanSighting sighting = sighting_of(0.5, 12.0, 4.0);
      const SideScanRows rows = side_scan_rows(x, sighting, landmark, config);
      EXPECT_GT(rows.vehicle.residual.norm(), 1e-2);
      const auto by_vehicle = [&](const VehicleVector& v) -> Eigen::VectorXd {
        return -side_scan_rows(v, sighting, landmark, config).vehicle.residual;
      };
      const auto by_landmark = [&](const Eigen::Vector3d& l) -> Eigen::VectorXd {
        return -side_scan_rows(x, sighting, l, config).vehicle.residual;
      };
      EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(rows.vehicle.H), Eigen::MatrixXd(numeric_jacobian(by_vehicle, x))));
      EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(rows.H_landmark), Eigen::MatrixXd(numeric_jacobian(by_landmark, landmark))));
    }
  }
}

TEST(SideScan, A12_NoiseByHand) {
  SideScanConfig config;
  config.along_track_sigma_m = 0.1;
  config.timing_sigma_s = 0.1;
  config.ping_interval_s = 0.2;
  config.beam_width_rad = 0.03;
  // 0.1^2 + (0.1 * 2)^2 + (0.2 * 2)^2 / 12 + (0.03 * 20)^2 / 12
  EXPECT_NEAR(side_scan_covariance(20.0, 2.0, config)(0, 0), 0.01 + 0.04 + 0.16 / 12.0 + 0.36 / 12.0, 1e-15);
}

TEST(SideScan, A13_ACorrelationOfADetectorTurnsWithTheSideOfItsRange) {
  SideScanConfig config;
  config.form = SideScanForm::kFlatBottom;
  for (const double side : {1.0, -1.0}) {
    SideScanSighting sighting = sighting_of(0.5, side * 12.0, 0.0);
    (*sighting.covariance)(0, 1) = (*sighting.covariance)(1, 0) = 0.02;
    const Eigen::Vector3d landmark(0.4, side * 11.0, 5.0);
    const SideScanRows rows = side_scan_rows(VehicleVector::Zero(), sighting, landmark, config);
    EXPECT_EQ(rows.vehicle.R(0, 1), side * 0.02);
    EXPECT_EQ(rows.vehicle.R(1, 0), side * 0.02);
  }
}

TEST(SideScan, A14_FlatBottomByHand) {
  // level vehicle at 10 m over a seabed at 14 m: 5 m of slant range to port is 3 m across
  VehicleVector x = VehicleVector::Zero();
  x(2) = 10.0;
  x(9) = 14.0;
  SideScanConfig config;
  config.form = SideScanForm::kFlatBottom;
  const auto landmark = landmark_from_side_scan(x, sighting_of(0.0, -5.0, 0.0), config);
  ASSERT_TRUE(landmark);
  EXPECT_NEAR((landmark->map_p_landmark - Eigen::Vector3d(0.0, -3.0, 14.0)).norm(), 0.0, 1e-12);
  EXPECT_FALSE(landmark_from_side_scan(x, sighting_of(0.0, -3.9, 0.0), config)) << "a range shorter than the altitude has no bottom";
}

TEST(SideScan, A14_NewLandmarkReproducesItsSightingAndItsJacobian) {
  Rng rng(62);
  for (const SideScanForm form : {SideScanForm::kPoint, SideScanForm::kFlatBottom}) {
    SideScanConfig config;
    config.form = form;
    for (int point = 0; point < kJacobianPoints; ++point) {
      VehicleVector x = random_vehicle(rng, point);
      x(3) *= 0.3;
      x(4) *= 0.3;
      const SideScanSighting sighting = sighting_of(rng.uniform(-0.5, 0.5), (point % 3 == 0 ? -1.0 : 1.0) * rng.uniform(12, 30), 4.0);
      const auto landmark = landmark_from_side_scan(x, sighting, config);
      ASSERT_TRUE(landmark);
      EXPECT_NEAR(side_scan_rows(x, sighting, landmark->map_p_landmark, config).vehicle.residual.norm(), 0.0, 1e-10);
      const auto placed = [&](const VehicleVector& v) { return landmark_from_side_scan(v, sighting, config)->map_p_landmark; };
      EXPECT_TRUE(jacobians_agree(landmark->J_vehicle, numeric_jacobian(placed, x)));
      // the noise: the same function by the measurement, and by the height of the bottom
      const auto by_measurement = [&](const Eigen::Vector3d& m) {
        SideScanSighting moved = sighting;
        VehicleVector state = x;
        moved.vehicle_p_point = m;
        if (form == SideScanForm::kFlatBottom) {  // the range is unsigned in the noise; the third number is the height of the bottom
          moved.vehicle_p_point.y() = std::copysign(m.y(), sighting.vehicle_p_point.y());
          state(VehicleLayout::kSeabed) += m.z();
        }
        return landmark_from_side_scan(state, moved, config)->map_p_landmark;
      };
      Eigen::Vector3d at = sighting.vehicle_p_point;
      Eigen::Matrix3d covariance = *sighting.covariance;
      if (form == SideScanForm::kFlatBottom) {
        at = {at.x(), std::abs(at.y()), 0.0};
        covariance(2, 2) = config.flat_bottom_sigma_m * config.flat_bottom_sigma_m;
      }
      const Eigen::Matrix3d J = numeric_jacobian(by_measurement, at);
      EXPECT_NEAR((J * covariance * J.transpose() - landmark->noise).norm(), 0.0, 1e-6);
    }
  }
}

}  // namespace
}  // namespace ssjs
