/// One seabed for many missions: each dives somewhere on it, on its own course, and knows its place on earth as well as its receiver does.
/// docs/math/season.md.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ssjs/base/config_field.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {

/// Seabed frame: x north, y east from its corner, z depth.
struct SharedSeabedConfig {
  int world_seed = 0;
  double north_m = 250.0, east_m = 250.0;
  int landmarks = 120;
  double origin_sigma_m = 3.0;
  double compass_offset_sigma_rad = 0.02;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("world_seed", world_seed, Rule::not_negative(), "places the landmarks: missions of one world_seed share them");
    v.field("north_m", north_m, Rule::positive(), "extent of the seabed to the north");
    v.field("east_m", east_m, Rule::positive(), "extent of the seabed to the east");
    v.field("landmarks", landmarks, Rule::not_negative(), "points on the seabed");
    v.field("origin_sigma_m", origin_sigma_m, Rule::not_negative(), "error of the place at which a mission believes to start, each axis");
    v.field("compass_offset_sigma_rad", compass_offset_sigma_rad, Rule::not_negative(), "of the compass offset at the start of a mission");
  }
};

struct PlacedSurvey {
  SurveyWorld world;                    ///< in the frame of the mission: x north, y east from where it starts
  Eigen::Matrix3Xd seabed_p_landmarks;  ///< the same landmarks, 3xn
  Eigen::Vector2d seabed_p_start = Eigen::Vector2d::Zero();
  Eigen::Vector2d seabed_p_origin = Eigen::Vector2d::Zero();  ///< where the mission believes to start
  double compass_offset_rad = 0.0;
};

/// `lines` (without its landmarks) turned to any heading, their middle in the inner half of the seabed. Stream "landmarks" of the world
/// seed; "place", "origin" and "compass offset" of the mission's seed.
[[nodiscard]] PlacedSurvey survey_on_shared_seabed(const SharedSeabedConfig& config, SurveyWorldConfig lines, std::uint64_t seed);

}  // namespace ssjs
