#include "ssjs/simulation/value_noise.hpp"

namespace ssjs {
namespace {

/// 0 and 1 with first and second derivatives of 0 at both.
float eased(float t) { return t * t * t * (t * (6.0F * t - 15.0F) + 10.0F); }

}  // namespace

ValueNoise::ValueNoise(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double length_m, Rng rng)
    : lattice_(from_m, to_m, length_m) {
  for (int row = 0; row < lattice_.rows(); ++row) {
    for (int column = 0; column < lattice_.columns(); ++column) lattice_.at(row, column) = static_cast<float>(rng.uniform(-1.0, 1.0));
  }
}

float ValueNoise::at(double x_m, double y_m) const {
  const Raster<float>::Cell cell = lattice_.cell(x_m, y_m);
  return bilinear(cell.low[0], cell.low[1], cell.high[0], cell.high[1], eased(cell.across), eased(cell.along));  // (CS-1)
}

}  // namespace ssjs
