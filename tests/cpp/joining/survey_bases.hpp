/// Where the bases of a simulated survey's maps really are.
#pragma once

#include <vector>

#include "mapping/survey_run.hpp"

namespace ssjs::testing {

/// Of the maps, and of the end of the last one, in the frame of the first.
inline std::vector<Se2> true_bases(const SimulatedSurvey& survey, const std::vector<LevelledSubmap>& maps) {
  const Se2 base_T_world = level_pose(survey.truth.front()).inverse();
  std::vector<Se2> bases;
  for (const LevelledSubmap& map : maps) bases.push_back(base_T_world * level_pose(truth_at(survey, map.start_time_s)));
  bases.push_back(base_T_world * level_pose(truth_at(survey, maps.back().end_time_s)));
  return bases;
}

}  // namespace ssjs::testing
