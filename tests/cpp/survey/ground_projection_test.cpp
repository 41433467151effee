#include "ssjs/survey/ground_projection.hpp"

#include <gtest/gtest.h>

#include "ssjs/base/random.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs {
namespace {

const PinholeCamera kCamera{320, 240, 300.0, 310.0, 158.0, 121.0};

TEST(GroundProjectionTest, V26_PixelsLieWhereTheCameraShowsThem) {
  CameraConfig mount;
  mount.mount_forward_m = 0.4;
  mount.mount_down_m = 0.2;
  mount.mount_roll_rad = 0.05;
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    const Se3 pose{{rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(1, 4)}, {rng.normal(0.1), rng.normal(0.1), rng.uniform(-3.1, 3.1)}};
    const double ground = 12.0;
    const auto H = ground_H_frame(pose, ground, kCamera, mount);
    ASSERT_TRUE(H);
    VehicleVector state = VehicleVector::Zero();
    state.head<3>() = pose.translation;
    state.segment<3>(3) = pose.rpy;
    const Eigen::Vector3d there = *H * Eigen::Vector3d(40.0, 200.0, 1.0);
    const auto seen = predict_pixel(state, Eigen::Vector3d(there.x() / there.z(), there.y() / there.z(), ground), kCamera, mount);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->pixel.x(), 40.0, 1e-8);
    EXPECT_NEAR(seen->pixel.y(), 200.0, 1e-8);
  }
  EXPECT_FALSE(ground_H_frame({{0, 0, 5}, {0, 0, 0}}, 5.1, kCamera, mount));  // the camera is below that ground
}

}  // namespace
}  // namespace ssjs
