#include "ssjs/survey/side_scan_geometry.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/se3.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using Inputs = Eigen::Matrix<double, kSideScanInputs, 1>;

SideScanEcho echo_of(const Inputs& x, SonarSide side) { return {side, x(kSlantRange), x(kAltitude), x(kRoll), x(kPitch)}; }

SideScanGeometryConfig config_of(const Inputs& x) {
  SideScanGeometryConfig config;
  config.sonar_x_m = 0.4;
  config.sonar_y_m = 0.1;
  config.sonar_z_m = 0.05;
  config.slope_forward = x(kSlopeForward);
  config.slope_starboard = x(kSlopeStarboard);
  return config;
}

Inputs random_inputs(Rng& rng) {
  Inputs x;
  x << rng.uniform(8, 50), rng.uniform(2, 6), rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.2, 0.2),
      rng.uniform(-0.2, 0.2), 0.0;
  return x;
}

TEST(SideScanGeometryTest, SS2_SlantRangeOfASampleAndBack) {
  SideScanPing ping;
  ping.sound_speed_m_s = 1500;
  SideScanChannel channel;
  channel.first_sample_s = 0.002;      // 1.5 m
  channel.sample_interval_s = 0.0001;  // 7.5 cm
  EXPECT_NEAR(slant_range_m(ping, channel, 100), 9.0, 1e-12);
  EXPECT_NEAR(sample_at_slant_range(ping, channel, 9.0), 100, 1e-9);
  ping.sound_speed_m_s = SideScanPing::kUnknown;
  EXPECT_THROW(static_cast<void>(slant_range_m(ping, channel, 100)), InvalidArgument);
}

TEST(SideScanGeometryTest, SS4_LevelOverFlatGroundIsPythagoras) {
  SideScanGeometryConfig config;
  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    const auto body = body_point({side, 5.0, 3.0, 0, 0}, config);
    ASSERT_TRUE(body);
    EXPECT_NEAR(body->position_m.y(), side == SonarSide::kPort ? -4 : 4, 1e-12);
    EXPECT_NEAR(body->position_m.z(), 3, 1e-12);
    EXPECT_EQ(body->position_m.x(), 0);
    EXPECT_NEAR(*ground_range_on_slope_m({side, 5.0, 3.0, 0, 0}, config), 4, 1e-12);
  }
  EXPECT_FALSE(body_point({SonarSide::kPort, 2.99, 3.0, 0, 0}, config)) << "the water column has no point";
  EXPECT_THROW(static_cast<void>(body_point({SonarSide::kPort, 5, std::nan(""), 0, 0}, config)), InvalidArgument);
}

TEST(SideScanGeometryTest, SS4_ThePointLiesInTheFanOnThePlaneAtTheRange) {
  Rng rng(4);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Inputs x = random_inputs(rng);
    const SonarSide side = point % 2 == 0 ? SonarSide::kPort : SonarSide::kStarboard;
    const SideScanGeometryConfig config = config_of(x);
    const auto body = solve_in_body(echo_of(x, side), config);
    const auto levelled = solve_levelled(echo_of(x, side), config);
    ASSERT_TRUE(body && levelled);
    const Eigen::Matrix3d tilt = rotation_from_rpy({x(kRoll), x(kPitch), 0});
    const Eigen::Vector3d sonar(0.4, starboard_sign(side) * 0.1, 0.05);
    const Eigen::Vector3d ray = body->position_m - sonar;
    EXPECT_NEAR(ray.norm(), x(kSlantRange), 1e-10);
    EXPECT_NEAR(ray.x(), 0, 1e-12);
    EXPECT_GT(starboard_sign(side) * ray.y(), 0);
    EXPECT_TRUE(levelled->position_m.isApprox(tilt * body->position_m, 1e-12));
    const Eigen::Vector3d from_sonar = tilt * ray;
    EXPECT_NEAR(from_sonar.z(), x(kAltitude) + x(kSlopeForward) * from_sonar.x() + x(kSlopeStarboard) * from_sonar.y(), 1e-10);
  }
}

TEST(SideScanGeometryTest, SS7_JacobiansAreCentralDifferences) {
  Rng rng(5);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Inputs x = random_inputs(rng);
    const SonarSide side = point % 2 == 0 ? SonarSide::kPort : SonarSide::kStarboard;
    const auto in_body = [&](const Inputs& v) -> Eigen::Vector3d {
      return solve_in_body(echo_of(v, side), config_of(v))->position_m + Eigen::Vector3d(v(kAlongTrack), 0, 0);
    };
    const auto in_level = [&](const Inputs& v) -> Eigen::Vector3d { return rotation_from_rpy({v(kRoll), v(kPitch), 0}) * in_body(v); };
    EXPECT_TRUE(jacobians_agree(solve_in_body(echo_of(x, side), config_of(x))->jacobian, numeric_jacobian(in_body, x)));
    EXPECT_TRUE(jacobians_agree(solve_levelled(echo_of(x, side), config_of(x))->jacobian, numeric_jacobian(in_level, x)));
  }
}

TEST(SideScanGeometryTest, SS9_CovarianceOfDrawnErrors) {
  SideScanGeometryConfig config;
  const SideScanEcho truth{SonarSide::kStarboard, 22, 5, 0.03, -0.02};
  const auto point = levelled_point(truth, config);
  ASSERT_TRUE(point);
  Rng rng(6);
  constexpr int kDraws = 20000;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    SideScanEcho echo = truth;
    SideScanGeometryConfig drawn = config;
    echo.slant_range_m += rng.normal(config.range_sigma_m) + config.sample_m * rng.uniform(-0.5, 0.5);
    echo.altitude_m += rng.normal(config.altitude_sigma_m);
    echo.roll_rad += rng.normal(config.roll_sigma_rad);
    echo.pitch_rad += rng.normal(config.pitch_sigma_rad);
    drawn.slope_forward += rng.normal(config.slope_sigma);
    drawn.slope_starboard += rng.normal(config.slope_sigma);
    const double along = rng.normal(config.beam_width_rad * 22 / 2.3548) + rng.normal(config.time_sigma_s * config.speed_m_s);
    const Eigen::Vector3d body = solve_in_body(echo, drawn)->position_m + Eigen::Vector3d(along, 0, 0);
    const Eigen::Vector3d error = rotation_from_rpy({echo.roll_rad, echo.pitch_rad, 0}) * body - point->position_m;
    sum += error * error.transpose();
  }
  const Eigen::Matrix3d sampled = sum / kDraws;
  // A sampled variance of n draws has the relative error sqrt(2 / n) = 1 %: five of them, with correlations in the whitened frame.
  const Eigen::Matrix3d L = point->covariance_m2.llt().matrixL();
  const Eigen::Matrix3d whitened = L.inverse() * sampled * L.inverse().transpose();
  EXPECT_LT((whitened - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 0.06) << whitened;
}

}  // namespace
}  // namespace ssjs
