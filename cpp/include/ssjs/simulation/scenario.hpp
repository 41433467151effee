/// The built-in scenarios by name. docs/scenarios.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ssjs/simulation/vehicle_simulator.hpp"
#include "ssjs/simulation/world.hpp"

namespace ssjs {

struct Scenario {
  World world;
  VehicleSimulationConfig config;
};

/// "grid-survey", "grid-survey-stress", "large-world", "revisit", "aekf-loop".
[[nodiscard]] std::vector<std::string> scenario_names();

/// The seed places the landmarks where the scenario jitters them. An unknown name throws InvalidArgument listing the known ones.
[[nodiscard]] Scenario built_in_scenario(const std::string& name, std::uint64_t seed);

/// Scenario S: 80 controls a second, 3.3 scans a second.
[[nodiscard]] VehicleSimulationConfig grid_survey_config();
/// The same noise per control at 10 controls a second: 2.8 times noisier per second.
[[nodiscard]] VehicleSimulationConfig grid_survey_stress_config();
/// 10 controls and 2 scans a second with better odometry, for missions of many kilometres.
[[nodiscard]] VehicleSimulationConfig large_world_config();
/// The sonar loop: wheelbase 4 m, 80 controls and 10 scans a second, 30 m of range.
[[nodiscard]] VehicleSimulationConfig aekf_loop_config();

}  // namespace ssjs
