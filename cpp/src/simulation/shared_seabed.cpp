#include "ssjs/simulation/shared_seabed.hpp"

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/se2.hpp"

namespace ssjs {

PlacedSurvey survey_on_shared_seabed(const SharedSeabedConfig& config, SurveyWorldConfig lines, std::uint64_t seed) {
  throw_if_any(violations(config));
  lines.landmarks = 0;
  PlacedSurvey placed;
  placed.world = survey_world(lines, seed);

  Rng places = Rng(static_cast<std::uint64_t>(config.world_seed)).stream("landmarks");
  placed.seabed_p_landmarks.resize(3, config.landmarks);
  for (int i = 0; i < config.landmarks; ++i) {
    const double north = places.uniform(0.0, config.north_m);
    const double east = places.uniform(0.0, config.east_m);
    placed.seabed_p_landmarks.col(i) << north, east, lines.seabed_depth_m + places.normal(lines.landmark_height_sigma_m);
    placed.world.ids.push_back(i);
  }

  const Rng rng(seed);
  Rng place = rng.stream("place");
  const double heading = place.uniform(-kPi, kPi);
  const double north = place.uniform(0.25, 0.75) * config.north_m;
  const double east = place.uniform(0.25, 0.75) * config.east_m;
  const Se2 turn{0.0, 0.0, heading};
  const Eigen::Vector2d middle(0.5 * lines.line_length_m, 0.5 * lines.line_spacing_m * (lines.lines - 1));
  placed.seabed_p_start = Eigen::Vector2d(north, east) - turn * middle;
  for (Eigen::Vector2d& waypoint : placed.world.waypoints) waypoint = turn * waypoint;
  placed.world.landmarks_m = placed.seabed_p_landmarks;
  placed.world.landmarks_m.topRows<2>().colwise() -= placed.seabed_p_start;

  Rng origin = rng.stream("origin");
  const double north_error = origin.normal(config.origin_sigma_m);
  const double east_error = origin.normal(config.origin_sigma_m);
  placed.seabed_p_origin = placed.seabed_p_start + Eigen::Vector2d(north_error, east_error);
  placed.compass_offset_rad = rng.stream("compass offset").normal(config.compass_offset_sigma_rad);
  return placed;
}

}  // namespace ssjs
