/// A ring driven twice: what the tests of the joining methods join.
#pragma once

#include <cmath>
#include <vector>

#include "joining/gaussian_world.hpp"

namespace ssjs::testing {

/// Two laps of a ring: submaps k and k + 10 see the same landmarks, neighbours share some.
struct Laps {
  World world{{Se2{}}, Eigen::Matrix2Xd(2, 70)};
  std::vector<std::vector<int>> seen;

  explicit Laps(int submaps) {
    Rng rng(471);
    const double turn = 2.0 * kPi / 10.0;
    for (int k = 1; k <= submaps; ++k) world.global_T_base.push_back(world.global_T_base.back() * Se2{6.0, 0.0, 0.0} * Se2{0.0, 0.0, turn});
    const Eigen::Vector2d centre(3.0, 3.0 / std::tan(0.5 * turn));
    for (Eigen::Index i = 0; i < world.landmarks.cols(); ++i) {
      const double angle = rng.uniform(-kPi, kPi);
      world.landmarks.col(i) = centre + rng.uniform(6.0, 13.0) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    for (int k = 0; k < submaps; ++k) {
      const Eigen::Vector2d middle = world.global_T_base[static_cast<std::size_t>(k)] * Eigen::Vector2d(3.0, 0.0);
      seen.emplace_back();
      for (Eigen::Index i = 0; i < world.landmarks.cols(); ++i) {
        if ((world.landmarks.col(i) - middle).norm() < 4.5) seen.back().push_back(static_cast<int>(i));
      }
    }
  }
  [[nodiscard]] std::vector<Submap> draw(double sigma_m, Rng& rng) const {
    std::vector<Submap> submaps;
    for (std::size_t k = 0; k < seen.size(); ++k) submaps.push_back(noisy_submap(world, static_cast<int>(k), seen[k], sigma_m, rng));
    return submaps;
  }
};

}  // namespace ssjs::testing
