/// Point landmarks and the path through them. docs/scenarios.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace ssjs {

/// One flat frame for all of it, m. Identities are unique.
struct World {
  Eigen::Matrix2Xd landmarks_m;            ///< 2xn
  std::vector<std::int64_t> ids;           ///< n
  std::vector<Eigen::Vector2d> waypoints;  ///< the path to follow; the vehicle starts at the first, heading to the second
};

/// Scenario S: a 5 m grid of 21 x 21 landmarks over 100 x 100 m, and a lawn mower up (y = 2.5 + 10 k) and down again between its
/// own lines (y = 97.5 - 10 k).
[[nodiscard]] World grid_survey_world();

/// Landmarks alone, without a path: a grid from (0, 0), each landmark moved by up to jitter_m in x and in y. Row by row, ids from 0.
/// Stream "landmarks" of the seed. Needs columns >= 1, rows >= 1 and 0 <= jitter_m < spacing_m / 2.
[[nodiscard]] World grid_field(int columns, int rows, double spacing_m, double jitter_m, std::uint64_t seed);

/// Landmarks alone: `count` of them uniform over 0..width_m x 0..height_m, a draw nearer than min_distance_m to an earlier one being
/// repeated. Stream "landmarks" of the seed. Throws InvalidArgument where the field has no room for so many.
[[nodiscard]] World random_field(int count, double width_m, double height_m, double min_distance_m, std::uint64_t seed);

/// A large field for scaling: `columns` x `rows` landmarks spacing_m apart, each moved by up to jitter_m in x and in y, and a lawn
/// mower along x whose lines are line_spacing_m apart (no line is driven twice). Stream "landmarks" of the seed.
/// Needs columns >= 3, rows >= 2 and 0 <= jitter_m < spacing_m / 2.
[[nodiscard]] World exploration_world(int columns, int rows, double spacing_m, double jitter_m, double line_spacing_m, std::uint64_t seed);

/// The same field under one closed circuit driven `laps` times: lanes along y, two spacings apart, and back along the lower edge.
/// Needs columns >= 4, rows >= 5, laps >= 1 and 0 <= jitter_m < spacing_m / 2.
[[nodiscard]] World revisit_world(int columns, int rows, double spacing_m, double jitter_m, int laps, std::uint64_t seed);

/// The sonar loop: 200 x 200 m, 17 waypoints driven for one lap and three more, 54 landmarks along them. The first kAekfLoopQuoted
/// landmarks are those whose coordinates the source prints (table 10: ship, branch, body); the others are placed beside the path by the
/// stream "landmarks" of the seed, 4 to 22 m from it and at least 4 m from each other. docs/scenarios.md.
constexpr int kAekfLoopQuoted = 8;
[[nodiscard]] World aekf_loop_world(std::uint64_t seed);

/// Length of the polyline through the waypoints, m.
[[nodiscard]] double path_length_m(const World& world);

}  // namespace ssjs
