/// Where a sonar is when it pings: a lawn mower over the seabed. docs/math/side_scan.md (SS-24)
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/se3.hpp"
#include "ssjs/simulation/seabed.hpp"

namespace ssjs {

/// The sonar at one time. World frame: x north, y east, z down from the surface, m.
struct SonarPose {
  double time_s = 0.0;
  Se3 world_T_sonar;
  double speed_m_s = 0.0;
};

struct SurveyTrackConfig {
  int lines = 4;
  double line_length_m = 100.0;
  double line_spacing_m = 30.0;
  double speed_m_s = 1.5;
  double pings_per_s = 7.0;
  double altitude_m = 5.0;
  double roll_sigma_rad = 0.015;
  double pitch_sigma_rad = 0.01;
  double yaw_sigma_rad = 0.01;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("lines", lines, Rule::at_least(1), "parallel lines to north and back, joined by half circles");
    v.field("line_length_m", line_length_m, Rule::positive(), "of each");
    v.field("line_spacing_m", line_spacing_m, Rule::positive(), "between neighbours");
    v.field("speed_m_s", speed_m_s, Rule::positive(), "along the track");
    v.field("pings_per_s", pings_per_s, Rule::positive(), "one pose a ping");
    v.field("altitude_m", altitude_m, Rule::positive(), "kept above the plane of the seabed");
    v.field("roll_sigma_rad", roll_sigma_rad, Rule::not_negative(), "standard deviation of the swinging roll");
    v.field("pitch_sigma_rad", pitch_sigma_rad, Rule::not_negative(), "of the pitch");
    v.field("yaw_sigma_rad", yaw_sigma_rad, Rule::not_negative(), "of the heading about the course");
  }
};

/// The first line begins at `start_m` (north, east) and leads north; the next ones lie to the east. The sonar keeps its altitude over
/// the plane of the seabed. Attitudes swing as sums of three sines, phases from the stream "attitude" of the seed.
[[nodiscard]] std::vector<SonarPose> survey_track(const SurveyTrackConfig& config, const Seabed& seabed, const Eigen::Vector2d& start_m,
                                                  std::uint64_t seed);

}  // namespace ssjs
