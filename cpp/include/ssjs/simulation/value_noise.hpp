/// Smooth noise over the plane: random values on a lattice, joined by a polynomial. docs/math/camera_simulation.md (CS-1)
#pragma once

#include <Eigen/Core>

#include "ssjs/base/random.hpp"
#include "ssjs/simulation/raster.hpp"

namespace ssjs {

/// Mean 0, values in [-1, 1]; neighbouring lattice points are `length_m` apart and independent.
class ValueNoise {
 public:
  ValueNoise(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double length_m, Rng rng);
  [[nodiscard]] float at(double x_m, double y_m) const;

 private:
  Raster<float> lattice_;
};

}  // namespace ssjs
