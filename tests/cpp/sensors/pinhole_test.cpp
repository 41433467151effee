#include "ssjs/sensors/pinhole.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/numeric_jacobian.hpp"
#include "sensors/random_vehicle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_vehicle;

const PinholeCamera kCamera{320, 240, 380.0, 390.0, 161.0, 118.0};

CameraConfig tilted() {
  CameraConfig config;
  config.mount_roll_rad = 0.1;
  config.mount_pitch_rad = -0.2;
  config.mount_yaw_rad = 1.4;
  config.mount_forward_m = 0.3;
  config.mount_starboard_m = -0.1;
  config.mount_down_m = 0.2;
  return config;
}

/// Somewhere over a seabed 3 to 8 m below it.
VehicleVector over_seabed(Rng& rng, int point) {
  VehicleVector x = random_vehicle(rng, point);
  x(VehicleLayout::kAttitude) *= 0.2;
  x(VehicleLayout::kAttitude + 1) *= 0.2;
  x(VehicleLayout::kSeabed) = x(2) + rng.uniform(3.0, 8.0);
  return x;
}

TEST(PinholeTest, I1_I2_APointByHand) {
  // level, heading north, camera down with the top of the picture ahead: 2 m ahead and 1 m to starboard, 4 m below
  const auto seen = predict_pixel(VehicleVector::Zero(), Eigen::Vector3d(2.0, 1.0, 4.0), kCamera, {});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->pixel.x(), 161.0 + 380.0 * 1.0 / 4.0, 1e-9);
  EXPECT_NEAR(seen->pixel.y(), 118.0 - 390.0 * 2.0 / 4.0, 1e-9);
  EXPECT_FALSE(predict_pixel(VehicleVector::Zero(), Eigen::Vector3d(2.0, 1.0, -4.0), kCamera, {}));
}

TEST(PinholeTest, I3_TheDirectionIsAUnitVector) {
  EXPECT_NEAR(ray_direction(0.7, 0.3).norm(), 1.0, 1e-15);
  EXPECT_NEAR((ray_direction(0.0, 0.0) - Eigen::Vector3d::UnitZ()).norm(), 0.0, 1e-15);
  InverseDepth ray;
  ray << 1.0, 2.0, 3.0, 0.0, 0.0, 0.25;
  EXPECT_NEAR((to_point(ray).map_p_point - Eigen::Vector3d(1.0, 2.0, 7.0)).norm(), 0.0, 1e-14);
  ray(5) = 0.0;
  EXPECT_THROW((void)to_point(ray), InvalidArgument);
}

TEST(PinholeTest, I4_ARayShowsWhereItsPointDoes) {
  Rng rng(3);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const VehicleVector x = over_seabed(rng, point);
    InverseDepth ray;
    ray << x.head<3>() + Eigen::Vector3d(rng.uniform(-1, 1), rng.uniform(-1, 1), 0.1), rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), 0.2;
    const auto by_ray = predict_pixel(x, ray, kCamera, tilted());
    const auto by_point = predict_pixel(x, to_point(ray).map_p_point, kCamera, tilted());
    ASSERT_TRUE(by_ray && by_point);
    EXPECT_NEAR((by_ray->pixel - by_point->pixel).norm(), 0.0, 1e-8);
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(by_ray->H_landmark), Eigen::MatrixXd(by_point->H_landmark * to_point(ray).J)));
  }
}

TEST(PinholeTest, I2_I3_I4_Jacobians) {
  Rng rng(8);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const VehicleVector x = over_seabed(rng, point);
    const Eigen::Vector3d p = x.head<3>() + Eigen::Vector3d(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(3, 8));
    const auto seen = predict_pixel(x, p, kCamera, tilted());
    ASSERT_TRUE(seen);
    const auto by_vehicle = [&](const VehicleVector& v) -> Eigen::VectorXd { return predict_pixel(v, p, kCamera, tilted())->pixel; };
    const auto by_point = [&](const Eigen::Vector3d& q) -> Eigen::VectorXd { return predict_pixel(x, q, kCamera, tilted())->pixel; };
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(seen->H_vehicle), Eigen::MatrixXd(numeric_jacobian(by_vehicle, x))));
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(seen->H_landmark), Eigen::MatrixXd(numeric_jacobian(by_point, p))));

    InverseDepth ray;
    ray << x(0) + 0.4, x(1) - 0.3, x(2) + 0.2, rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(0.1, 0.5);
    const auto ray_seen = predict_pixel(x, ray, kCamera, tilted());
    ASSERT_TRUE(ray_seen);
    const auto ray_by_vehicle = [&](const VehicleVector& v) -> Eigen::VectorXd { return predict_pixel(v, ray, kCamera, tilted())->pixel; };
    const auto ray_by_ray = [&](const InverseDepth& y) -> Eigen::VectorXd { return predict_pixel(x, y, kCamera, tilted())->pixel; };
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(ray_seen->H_vehicle), Eigen::MatrixXd(numeric_jacobian(ray_by_vehicle, x))));
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(ray_seen->H_landmark), Eigen::MatrixXd(numeric_jacobian(ray_by_ray, ray))));
    const auto converted = [&](const InverseDepth& y) -> Eigen::VectorXd { return to_point(y).map_p_point; };
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(to_point(ray).J), Eigen::MatrixXd(numeric_jacobian(converted, ray))));
  }
}

TEST(PinholeTest, I5_ANewRayGoesThroughItsPixelDownToTheSeabed) {
  Rng rng(12);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const VehicleVector x = over_seabed(rng, point);
    const Eigen::Vector2d pixel(rng.uniform(0, 320), rng.uniform(0, 240));
    const auto made = ray_from_pixel(x, pixel, kCamera, tilted());
    ASSERT_TRUE(made);
    const Eigen::Vector3d p = to_point(made->ray).map_p_point;
    EXPECT_NEAR(p.z(), x(VehicleLayout::kSeabed), 1e-9);
    EXPECT_NEAR((predict_pixel(x, made->ray, kCamera, tilted())->pixel - pixel).norm(), 0.0, 1e-8);
  }
}

TEST(PinholeTest, I6_JacobiansOfANewRay) {
  Rng rng(13);
  CameraConfig config = tilted();
  config.relief = 1e-12;  // only the pixel's noise is left
  for (int point = 0; point < kJacobianPoints; ++point) {
    const VehicleVector x = over_seabed(rng, point);
    const Eigen::Vector2d pixel(rng.uniform(0, 320), rng.uniform(0, 240));
    const auto made = ray_from_pixel(x, pixel, kCamera, config);
    ASSERT_TRUE(made);
    const auto by_vehicle = [&](const VehicleVector& v) -> Eigen::VectorXd { return ray_from_pixel(v, pixel, kCamera, config)->ray; };
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(made->J_vehicle), Eigen::MatrixXd(numeric_jacobian(by_vehicle, x))));
    const auto by_pixel = [&](const Eigen::Vector2d& uv) -> Eigen::VectorXd { return ray_from_pixel(x, uv, kCamera, config)->ray; };
    const Eigen::MatrixXd J = numeric_jacobian(by_pixel, pixel);
    EXPECT_TRUE(jacobians_agree(Eigen::MatrixXd(made->noise), Eigen::MatrixXd(J * J.transpose())));
  }
}

TEST(PinholeTest, I6_ReliefByHand) {
  VehicleVector x = VehicleVector::Zero();
  x(VehicleLayout::kSeabed) = 5.0;
  const auto made = ray_from_pixel(x, {161.0, 118.0}, kCamera, {});
  ASSERT_TRUE(made);
  EXPECT_NEAR(made->ray(5), 0.2, 1e-12);
  EXPECT_NEAR(made->noise(5, 5), 0.06 * 0.06, 1e-12);  // 0.3 of it; straight down a pixel does not change the depth
  x(VehicleLayout::kSeabed) = -1.0;
  EXPECT_FALSE(ray_from_pixel(x, {161.0, 118.0}, kCamera, {}));
}

TEST(PinholeTest, I7_ParallaxAndDepthMakeAPoint) {
  InverseDepth ray;
  ray << 0.0, 0.0, 0.0, 0.0, 0.0, 0.2;  // 5 m below the first camera
  // from there: sigma of the depth 0.02 / 0.04 = 0.5 m of 5 m, no parallax
  EXPECT_NEAR(linearity_index(ray, 0.02, {0.0, 0.0, 0.0}), 4.0 * 0.5 / 5.0, 1e-12);
  // 5 m aside: 45 degrees of parallax, sqrt(50) m away
  EXPECT_NEAR(linearity_index(ray, 0.02, {5.0, 0.0, 0.0}), 4.0 * 0.5 * std::sqrt(0.5) / std::sqrt(50.0), 1e-12);
}

}  // namespace
}  // namespace ssjs
