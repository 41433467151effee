/// States at which the models of an underwater vehicle are checked.
#pragma once

#include "ssjs/base/random.hpp"
#include "ssjs/sensors/vehicle_state.hpp"

namespace ssjs::testing {

/// Pitch and roll up to 60 degrees; every other yaw within 1e-4 rad of +-pi, where wrapping goes wrong first.
inline VehicleVector random_vehicle(Rng& rng, int point) {
  VehicleVector x;
  for (Eigen::Index i = 0; i < 3; ++i) {
    x(i) = rng.uniform(-20.0, 20.0);
    x(3 + i) = rng.uniform(-1.0, 1.0);
    x(6 + i) = rng.uniform(-2.0, 2.0);
    x(12 + i) = rng.uniform(-0.3, 0.3);
    x(15 + i) = rng.uniform(-0.1, 0.1);
  }
  x(5) = point % 2 == 0 ? rng.uniform(-kPi, kPi) : wrap_angle(kPi + rng.uniform(-1e-4, 1e-4));
  x(9) = x(2) + rng.uniform(2.0, 8.0);
  x(10) = rng.uniform(-kPi, kPi);
  x(11) = rng.uniform(-kPi, kPi);
  x(18) = rng.uniform(-0.1, 0.1);
  x(19) = rng.uniform(-0.2, 0.2);
  return x;
}

}  // namespace ssjs::testing
