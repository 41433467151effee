#include "ssjs/simulation/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

void place_grid(World& world, int columns, int rows, double spacing_m) {
  world.landmarks_m.resize(2, static_cast<Eigen::Index>(columns) * rows);
  Eigen::Index landmark = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column, ++landmark) {
      world.landmarks_m.col(landmark) << spacing_m * column, spacing_m * row;
      world.ids.push_back(landmark);
    }
  }
}

void jitter(World& world, double jitter_m, std::uint64_t seed) {
  Rng landmarks = Rng(seed).stream("landmarks");
  for (Eigen::Index i = 0; i < world.landmarks_m.cols(); ++i) {
    world.landmarks_m(0, i) += landmarks.uniform(-jitter_m, jitter_m);
    world.landmarks_m(1, i) += landmarks.uniform(-jitter_m, jitter_m);
  }
}

/// Two waypoints of a lawn-mower line at height y, driven to the right or to the left.
void add_line(World& world, double y, double x_left, double x_right, bool to_right) {
  world.waypoints.emplace_back(to_right ? x_left : x_right, y);
  world.waypoints.emplace_back(to_right ? x_right : x_left, y);
}

void check_field(const std::string& world, int columns, int min_columns, int rows, int min_rows, double spacing_m, double jitter_m) {
  if (columns < min_columns) throw InvalidArgument(world + " columns", columns, "must be at least " + std::to_string(min_columns));
  if (rows < min_rows) throw InvalidArgument(world + " rows", rows, "must be at least " + std::to_string(min_rows));
  if (!(spacing_m > 0.0) || !std::isfinite(spacing_m))
    throw InvalidArgument(world + " spacing_m", spacing_m, "must be positive and finite");
  if (!(jitter_m >= 0.0 && jitter_m < 0.5 * spacing_m)) {
    throw InvalidArgument(world + " jitter_m", jitter_m, "must be at least 0 and below half the spacing, so that landmarks stay apart");
  }
}

}  // namespace

World grid_survey_world() {
  World world;
  place_grid(world, 21, 21, 5.0);
  constexpr int kLines = 10;
  for (int k = 0; k < kLines; ++k) add_line(world, 2.5 + 10.0 * k, 5.0, 95.0, k % 2 == 0);
  for (int k = 0; k < kLines; ++k) add_line(world, 97.5 - 10.0 * k, 5.0, 95.0, k % 2 == 0);
  return world;
}

World grid_field(int columns, int rows, double spacing_m, double jitter_m, std::uint64_t seed) {
  check_field("grid_field", columns, 1, rows, 1, spacing_m, jitter_m);
  World world;
  place_grid(world, columns, rows, spacing_m);
  if (jitter_m > 0.0) jitter(world, jitter_m, seed);
  return world;
}

World random_field(int count, double width_m, double height_m, double min_distance_m, std::uint64_t seed) {
  if (count < 1) throw InvalidArgument("random_field count", count, "must be at least 1");
  for (const auto& [name, value] : {std::pair{"random_field width_m", width_m}, std::pair{"random_field height_m", height_m}}) {
    if (!(value > 0.0) || !std::isfinite(value)) throw InvalidArgument(name, value, "must be positive and finite");
  }
  if (!(min_distance_m >= 0.0) || !std::isfinite(min_distance_m)) {
    throw InvalidArgument("random_field min_distance_m", min_distance_m, "must be at least 0 and finite");
  }
  constexpr int kDrawsPerLandmark = 1000;
  // cells no smaller than the distance, so that neighbours hold every landmark in reach, and no smaller than the usual spacing
  const double cell_m = std::max(min_distance_m, std::sqrt(width_m * height_m / count));
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Eigen::Index>> cells;
  World world;
  world.landmarks_m.resize(2, count);
  const auto has_room = [&](const Eigen::Vector2d& p, std::int64_t column, std::int64_t row) {
    for (std::int64_t near_column = column - 1; near_column <= column + 1; ++near_column) {
      for (std::int64_t near_row = row - 1; near_row <= row + 1; ++near_row) {
        const auto cell = cells.find({near_column, near_row});
        if (cell == cells.end()) continue;
        for (const Eigen::Index i : cell->second) {
          if ((world.landmarks_m.col(i) - p).norm() < min_distance_m) return false;
        }
      }
    }
    return true;
  };
  Rng landmarks = Rng(seed).stream("landmarks");
  for (Eigen::Index landmark = 0; landmark < count; ++landmark) {
    bool placed = false;
    for (int draw = 0; draw < kDrawsPerLandmark && !placed; ++draw) {
      const double x_m = landmarks.uniform(0.0, width_m);
      const double y_m = landmarks.uniform(0.0, height_m);
      const Eigen::Vector2d p(x_m, y_m);
      const auto column = static_cast<std::int64_t>(x_m / cell_m);
      const auto row = static_cast<std::int64_t>(y_m / cell_m);
      if (!has_room(p, column, row)) continue;
      world.landmarks_m.col(landmark) = p;
      world.ids.push_back(landmark);
      cells[{column, row}].push_back(landmark);
      placed = true;
    }
    if (!placed) {
      throw InvalidArgument("random_field min_distance_m", min_distance_m,
                            "leaves room for about " + std::to_string(landmark) + " landmarks, not " + std::to_string(count));
    }
  }
  return world;
}

World exploration_world(int columns, int rows, double spacing_m, double jitter_m, double line_spacing_m, std::uint64_t seed) {
  check_field("exploration_world", columns, 3, rows, 2, spacing_m, jitter_m);
  if (!(line_spacing_m > 0.0) || !std::isfinite(line_spacing_m)) {
    throw InvalidArgument("exploration_world line_spacing_m", line_spacing_m, "must be positive and finite");
  }
  World world = grid_field(columns, rows, spacing_m, jitter_m, seed);
  const double width_m = spacing_m * (columns - 1);
  const double height_m = spacing_m * (rows - 1);
  // half a spacing from the first row, so that the first line runs between two rows
  for (int k = 0; k == 0 || 0.5 * spacing_m + line_spacing_m * k <= height_m; ++k) {
    add_line(world, 0.5 * spacing_m + line_spacing_m * k, 0.5 * spacing_m, width_m - 0.5 * spacing_m, k % 2 == 0);
  }
  return world;
}

World revisit_world(int columns, int rows, double spacing_m, double jitter_m, int laps, std::uint64_t seed) {
  check_field("revisit_world", columns, 4, rows, 5, spacing_m, jitter_m);
  if (laps < 1) throw InvalidArgument("revisit_world laps", laps, "must be at least 1");
  World world = grid_field(columns, rows, spacing_m, jitter_m, seed);
  const double lane_spacing_m = 2.0 * spacing_m;
  const double return_y_m = 0.5 * spacing_m;
  const double low_y_m = return_y_m + lane_spacing_m;
  const double high_y_m = spacing_m * (rows - 1.5);
  const int lanes = columns / 2 / 2 * 2;  // lane k lies half a spacing right of column 2 k; an even number ends at the lower edge
  std::vector<Eigen::Vector2d> circuit;
  for (int k = 0; k < lanes; ++k) {
    const double x_m = 0.5 * spacing_m + lane_spacing_m * k;
    const double start_y_m = k == 0 ? return_y_m : low_y_m;
    const double end_y_m = k == lanes - 1 ? return_y_m : low_y_m;
    circuit.emplace_back(x_m, k % 2 == 0 ? start_y_m : high_y_m);
    circuit.emplace_back(x_m, k % 2 == 0 ? high_y_m : end_y_m);
  }
  for (int lap = 0; lap < laps; ++lap) world.waypoints.insert(world.waypoints.end(), circuit.begin(), circuit.end());
  world.waypoints.push_back(circuit.front());
  return world;
}

World aekf_loop_world(std::uint64_t seed) {
  constexpr int kLandmarks = 54;
  constexpr double kNearest_m = 4.0;  // of two landmarks, and of a landmark to the path
  constexpr double kFarthest_m = 22.0;
  const std::vector<Eigen::Vector2d> circuit{{44, -21},  {59, 7},    {65, 36},   {46, 59}, {22, 73},   {-7, 78},
                                             {-37, 71},  {-65, 56},  {-84, 30},  {-95, 0}, {-98, -28}, {-91, -56},
                                             {-85, -79}, {-57, -89}, {-26, -81}, {4, -66}, {27, -46}};
  World world;
  world.waypoints = circuit;
  world.waypoints.insert(world.waypoints.end(), circuit.begin(), circuit.begin() + 4);
  std::vector<Eigen::Vector2d> landmarks{{53.5, 60.3},     {54.23, 65.39},    {18.73, -11.56},  {-94.98, -66.29},
                                         {-96.69, -66.06}, {-102.12, -61.57}, {-102.41, -70.3}, {-106.55, -81.13}};
  const auto distance_to_path = [&](const Eigen::Vector2d& p) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < circuit.size(); ++i) {
      const Eigen::Vector2d& from = circuit[i];
      const Eigen::Vector2d along = circuit[(i + 1) % circuit.size()] - from;
      const double t = std::clamp(along.dot(p - from) / along.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + t * along - p).norm());
    }
    return least;
  };
  Rng places = Rng(seed).stream("landmarks");
  while (landmarks.size() < kLandmarks) {
    const std::size_t i = places.below(circuit.size());
    const Eigen::Vector2d& from = circuit[i];
    const Eigen::Vector2d along = circuit[(i + 1) % circuit.size()] - from;
    const Eigen::Vector2d left = Eigen::Vector2d(-along.y(), along.x()).normalized();
    const double t = places.uniform();
    const double offset_m = places.uniform(-kFarthest_m, kFarthest_m);
    const Eigen::Vector2d place = from + t * along + offset_m * left;
    const auto near = [&](const Eigen::Vector2d& other) { return (other - place).norm() < kNearest_m; };
    if (distance_to_path(place) < kNearest_m || std::any_of(landmarks.begin(), landmarks.end(), near)) continue;
    landmarks.push_back(place);
  }
  world.landmarks_m.resize(2, kLandmarks);
  for (int i = 0; i < kLandmarks; ++i) {
    world.landmarks_m.col(i) = landmarks[static_cast<std::size_t>(i)];
    world.ids.push_back(i);
  }
  return world;
}

double path_length_m(const World& world) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < world.waypoints.size(); ++i) length_m += (world.waypoints[i] - world.waypoints[i - 1]).norm();
  return length_m;
}

}  // namespace ssjs
