/// The beginning of a simulated mission: a few submaps in a few milliseconds.
#pragma once

#include <algorithm>
#include <cstdint>

#include "pipeline/scenario_run.hpp"

namespace ssjs::testing {

/// The first `seconds` of the stress survey: 10 controls and 3.3 scans a second, about one submap every 5 s.
struct ShortSurvey {
  SimulatedMission mission;
  SlamConfig config;

  explicit ShortSurvey(double seconds, std::uint64_t seed = 3) {
    const Scenario scenario = built_in_scenario("grid-survey-stress", seed);
    mission = simulate(scenario.world, scenario.config, seed);
    config = matching_config(scenario.config);
    const auto end = std::find_if(mission.events.begin(), mission.events.end(), [&](const Event& event) { return event.time_s > seconds; });
    mission.events.erase(end, mission.events.end());
  }
};

}  // namespace ssjs::testing
