/// Levelled maps whose errors are exactly Gaussian with the covariance they state, drawn around a known truth: the survey of
/// docs/math/ports.md without a vehicle.
#pragma once

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "joining/gaussian_world.hpp"
#include "ssjs/joining/port_joiner.hpp"
#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs::testing {

struct LevelledWorld {
  std::vector<Se2> bases;       ///< global_T_base
  std::vector<double> offsets;  ///< compass minus heading, at every base
  std::vector<Eigen::Vector3d> landmarks;

  [[nodiscard]] PortValues values() const { return {bases, offsets, landmarks}; }
};

/// Standard deviations of a map: exit, compass entries, landmarks.
struct MapNoise {
  double exit_m = 0.15;
  double exit_rad = 0.005;
  double compass_rad = 0.0175;  ///< of c_s and c_e together
  double drift_rad = 0.006;     ///< of c_e - c_s beyond the true drift
  double landmark_m = 0.35;
  bool heading_is_apart = false;  ///< the exit heading is correlated with nothing
};

/// Covariance of a map of n landmarks: errors of the vehicle grow along the map and pull the landmarks with them.
inline Eigen::MatrixXd map_covariance(const MapNoise& noise, CompassPorts compass, Eigen::Index n, Rng& rng) {
  const Eigen::Index c = compass == CompassPorts::kBorders ? 2 : compass == CompassPorts::kConstant ? 1 : 0;
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(3 + c + 3 * n, noise.landmark_m);
  sigmas.head<3>() << noise.exit_m, noise.exit_m, noise.exit_rad;
  sigmas.segment(3, c).setConstant(noise.drift_rad);
  Eigen::MatrixXd P = correlated_covariance(rng, sigmas);
  if (noise.heading_is_apart) {
    const double variance = P(2, 2);
    P.row(2).setZero();
    P.col(2).setZero();
    P(2, 2) = variance;
  }
  P.block(3, 3, c, c).array() += noise.compass_rad * noise.compass_rad;  // the one error that all samples share
  return P;
}

/// Map k of these landmarks with an error drawn from `covariance`.
inline LevelledSubmap noisy_levelled_submap(const LevelledWorld& world, int k, const std::vector<int>& landmarks, CompassPorts compass,
                                            const Eigen::MatrixXd& covariance, Rng& rng) {
  LevelledSubmap submap;
  submap.index = k;
  submap.start_time_s = 30.0 * k;
  submap.end_time_s = 30.0 * (k + 1);
  submap.compass = compass;
  for (const int id : landmarks) submap.landmarks.push_back({1, id, {1000 * std::int64_t{k} + id}});
  std::vector<Port> all{{0, {UnknownKind::kBase, k + 1}}};
  const bool constant = compass == CompassPorts::kConstant;
  for (Eigen::Index i = 0; i < submap.compass_rows(); ++i) {
    all.push_back({3 + i, {UnknownKind::kOffset, constant ? 0 : k + static_cast<int>(i)}});
  }
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    all.push_back({submap.landmark_offset(static_cast<Eigen::Index>(i)), {UnknownKind::kLandmark, landmarks[i]}});
  }
  const Eigen::VectorXd truth = place_ports(k, all, world.values()).s;
  submap.covariance = covariance;
  submap.mean = truth + Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL() * normal_vector(rng, truth.size());
  for (Eigen::Index i = 2; i < 3 + submap.compass_rows(); ++i) submap.mean(i) = wrap_angle(submap.mean(i));
  return submap;
}

/// Lines of `line_m`, `spacing_m` apart, then three cross lines; a base every `map_m` along the way.
inline std::vector<Se2> lawn_mower_bases(int lines, double line_m, double spacing_m, double map_m) {
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < lines; ++i) {
    const double y = i * spacing_m;
    corners.emplace_back(i % 2 == 0 ? 0.0 : line_m, y);
    corners.emplace_back(i % 2 == 0 ? line_m : 0.0, y);
  }
  const double top = (lines - 1) * spacing_m;
  const bool at_far_end = lines % 2 == 1;
  for (int i = 0; i < 3; ++i) {
    const double fraction = at_far_end ? 0.8 - 0.3 * i : 0.2 + 0.3 * i;
    corners.emplace_back(fraction * line_m, i % 2 == 0 ? top : 0.0);
    corners.emplace_back(fraction * line_m, i % 2 == 0 ? 0.0 : top);
  }
  std::vector<Se2> bases;
  double next_m = 0.0;
  double walked_m = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i] - corners[i - 1];
    const double length = leg.norm();
    for (; next_m < walked_m + length; next_m += map_m) {
      const Eigen::Vector2d at = corners[i - 1] + leg * ((next_m - walked_m) / length);
      bases.push_back({at.x(), at.y(), std::atan2(leg.y(), leg.x())});
    }
    walked_m += length;
  }
  return bases;
}

/// Landmarks that the vehicle passes abeam between `from` and `to` at 3 to 30 m (straight between the bases).
inline std::vector<int> seen_between(const LevelledWorld& world, int k) {
  const Se2& from = world.bases[static_cast<std::size_t>(k)];
  const Se2& to = world.bases[static_cast<std::size_t>(k) + 1];
  const Eigen::Vector2d leg = to.translation() - from.translation();
  std::vector<int> seen;
  for (std::size_t i = 0; i < world.landmarks.size(); ++i) {
    const Eigen::Vector2d d = world.landmarks[i].head<2>() - from.translation();
    const double along = d.dot(leg) / leg.norm();
    const double across = std::abs(leg.x() * d.y() - leg.y() * d.x()) / leg.norm();
    if (along >= 0.0 && along < leg.norm() && across > 3.0 && across < 30.0) seen.push_back(static_cast<int>(i));
  }
  return seen;
}

/// The survey of docs/math/ports.md: 5 lines of 120 m, 20 m apart, 3 cross lines, 60 landmarks on 170 x 140 m.
inline LevelledWorld survey_world(Rng& rng, double map_m = 50.0, double drift_rad = 0.0048) {
  LevelledWorld world;
  world.bases = lawn_mower_bases(5, 120.0, 20.0, map_m);
  double offset = 0.7;
  for (std::size_t k = 0; k < world.bases.size(); ++k) {
    world.offsets.push_back(wrap_angle(offset));
    offset += rng.normal(drift_rad);
  }
  for (int i = 0; i < 60; ++i) {
    const double x = rng.uniform(-25.0, 145.0);
    const double y = rng.uniform(-30.0, 110.0);
    world.landmarks.emplace_back(x, y, rng.uniform(15.0, 18.0));
  }
  return world;
}

inline std::vector<LevelledSubmap> survey_maps(const LevelledWorld& world, const MapNoise& noise, CompassPorts compass, Rng& rng) {
  std::vector<LevelledSubmap> maps;
  for (int k = 0; k + 1 < static_cast<int>(world.bases.size()); ++k) {
    const std::vector<int> seen = seen_between(world, k);
    const Eigen::MatrixXd P = map_covariance(noise, compass, static_cast<Eigen::Index>(seen.size()), rng);
    maps.push_back(noisy_levelled_submap(world, k, seen, compass, P, rng));
  }
  return maps;
}

/// Additive errors of all bases but the first against their joint covariance.
struct BaseErrors {
  double joint_per_dof = 0.0;
  double position = 0.0;  ///< mean over bases, 2 degrees of freedom
  double heading = 0.0;   ///< mean over bases, 1 degree of freedom
  double rmse_m = 0.0;
};
inline BaseErrors base_errors(const PortLevel& level, const std::vector<Se2>& truth) {
  std::vector<Unknown> bases;
  for (std::size_t k = 1; k < level.values().bases.size(); ++k) bases.push_back({UnknownKind::kBase, static_cast<int>(k)});
  const Eigen::MatrixXd P = level.covariance(bases);
  Eigen::VectorXd error(P.rows());
  BaseErrors result;
  const auto count = static_cast<double>(bases.size());
  for (std::size_t i = 0; i < bases.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    error.segment<3>(at) = additive_difference(level.values().bases[i + 1], truth[i + 1]);
    result.position += error.segment<2>(at).dot(P.block<2, 2>(at, at).ldlt().solve(error.segment<2>(at))) / count;
    result.heading += error(at + 2) * error(at + 2) / P(at + 2, at + 2) / count;
    result.rmse_m += error.segment<2>(at).squaredNorm() / count;
  }
  result.joint_per_dof = error.dot(P.ldlt().solve(error)) / static_cast<double>(error.size());
  result.rmse_m = std::sqrt(result.rmse_m);
  return result;
}

}  // namespace ssjs::testing
