/// Surveys with weak odometry and what a place recogniser claims about them, some of it false: docs/math/closures.md.
#pragma once

#include <algorithm>
#include <vector>

#include "joining/levelled_world.hpp"
#include "ssjs/joining/closure.hpp"

namespace ssjs::testing {

inline const Eigen::Matrix3d kClaimNoise = Eigen::Vector3d(0.09, 0.09, 4e-4).asDiagonal();

struct Claim {
  Closure closure;
  bool is_false = false;
};

inline Claim claim(const LevelledWorld& world, int from, int to, const Eigen::Vector2d& offset_m, Rng& rng) {
  Se2 there = world.bases[static_cast<std::size_t>(to)];
  there.x += offset_m.x();
  there.y += offset_m.y();
  const Se2 claimed = world.bases[static_cast<std::size_t>(from)].inverse() * there;
  const Eigen::Vector3d error = Eigen::LLT<Eigen::Matrix3d>(kClaimNoise).matrixL() * normal_vector(rng, 3);
  return {{from, to, GaussianSe2{additive_step(claimed, error), kClaimNoise}, {}, "claim"}, offset_m.norm() > 0.0};
}

/// Every base that comes within 25 m of an older one (five maps ago or more) is recognised with probability 0.7: the true claims. False
/// ones until they are `share` of all: between any two such places, off by 5 to 50 m in any direction; half of them in groups of three
/// successive bases with one common offset, which agree with each other. In the order in which they can be made.
inline std::vector<Claim> claims(const LevelledWorld& world, double share, Rng& rng) {
  std::vector<std::pair<int, int>> places;
  const auto n = static_cast<int>(world.bases.size());
  for (int to = 0; to < n; ++to) {
    for (int from = 0; from + 5 <= to; ++from) {
      const Eigen::Vector2d d =
          world.bases[static_cast<std::size_t>(to)].translation() - world.bases[static_cast<std::size_t>(from)].translation();
      if (d.norm() < 25.0) places.emplace_back(from, to);
    }
  }
  std::vector<Claim> all;
  int last = -1;
  for (const auto& [from, to] : places) {
    if (to == last || rng.uniform() > 0.7) continue;
    last = to;  // one a base
    all.push_back(claim(world, from, to, Eigen::Vector2d::Zero(), rng));
  }
  const auto wanted = static_cast<int>(std::lround(share / (1.0 - share) * static_cast<double>(all.size())));
  const auto offset = [&]() -> Eigen::Vector2d {
    const double length_m = rng.uniform(5.0, 50.0);
    const double direction = rng.uniform(-kPi, kPi);
    return {length_m * std::cos(direction), length_m * std::sin(direction)};
  };
  const auto any_place = [&] {
    return places[std::min(places.size() - 1, static_cast<std::size_t>(rng.uniform() * static_cast<double>(places.size())))];
  };
  int made = 0;
  while (made + 3 <= (wanted + 1) / 2) {
    const auto [from, to] = any_place();
    if (to + 2 >= n) continue;
    const Eigen::Vector2d common = offset();
    for (int i = 0; i < 3; ++i, ++made) all.push_back(claim(world, from + i, to + i, common, rng));
  }
  for (; made < wanted; ++made) {
    const auto [from, to] = any_place();
    all.push_back(claim(world, from, to, offset(), rng));
  }
  std::stable_sort(all.begin(), all.end(), [](const Claim& a, const Claim& b) { return a.closure.to < b.closure.to; });
  return all;
}

/// Ten lines of 150 m, 20 m apart, and three across; no compass; exits off by 0.4 m and 1.1 deg a map of 30 m.
inline LevelledWorld weak_world(Rng& rng) {
  LevelledWorld world;
  world.bases = lawn_mower_bases(10, 150.0, 20.0, 30.0);
  world.offsets.assign(world.bases.size(), 0.0);
  for (int i = 0; i < 120; ++i) {
    const double x = rng.uniform(-25.0, 175.0);
    const double y = rng.uniform(-30.0, 210.0);
    world.landmarks.emplace_back(x, y, rng.uniform(15.0, 18.0));
  }
  return world;
}
inline constexpr MapNoise kWeakNoise{0.4, 0.02, 0.0175, 0.006, 0.35, false};

}  // namespace ssjs::testing
