// Where a wreck lies as seen from the vehicle: a user of ssjs::slam.
#include <Eigen/Core>
#include <cstdio>

#include "ssjs/geometry/se2.hpp"

int main() {
  const ssjs::Se2 global_T_vehicle{10.0, 5.0, ssjs::kPi / 2.0};
  const Eigen::Vector2d global_p_wreck(10.0, 25.0);
  const Eigen::Vector2d vehicle_p_wreck = global_T_vehicle.inverse() * global_p_wreck;
  std::printf("the wreck lies %.3f m ahead, %.3f m to the left\n", vehicle_p_wreck.x(), vehicle_p_wreck.y());
  return (vehicle_p_wreck - Eigen::Vector2d(20.0, 0.0)).norm() < 1e-12 ? 0 : 1;
}
