#include "ssjs/simulation/scenario.hpp"

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr double kRadPerDeg = kPi / 180.0;

struct NamedScenario {
  const char* name;
  Scenario (*build)(std::uint64_t seed);
};

const NamedScenario kScenarios[] = {
    {"grid-survey",
     [](std::uint64_t) {
       return Scenario{grid_survey_world(), grid_survey_config()};
     }},
    {"grid-survey-stress",
     [](std::uint64_t) {
       return Scenario{grid_survey_world(), grid_survey_stress_config()};
     }},
    {"large-world",
     [](std::uint64_t seed) {
       return Scenario{exploration_world(200, 100, 5.0, 1.0, 10.0, seed), large_world_config()};
     }},
    {"revisit",
     [](std::uint64_t seed) {
       return Scenario{revisit_world(20, 20, 5.0, 1.0, 5, seed), large_world_config()};
     }},
    {"aekf-loop",
     [](std::uint64_t seed) {
       return Scenario{aekf_loop_world(seed), aekf_loop_config()};
     }},
};

}  // namespace

std::vector<std::string> scenario_names() {
  std::vector<std::string> names;
  for (const NamedScenario& scenario : kScenarios) names.emplace_back(scenario.name);
  return names;
}

Scenario built_in_scenario(const std::string& name, std::uint64_t seed) {
  std::string known;
  for (const NamedScenario& scenario : kScenarios) {
    if (name == scenario.name) return scenario.build(seed);
    known += (known.empty() ? "" : ", ") + std::string(scenario.name);
  }
  throw InvalidArgument("scenario", name, "must be one of " + known);
}

VehicleSimulationConfig grid_survey_config() {
  VehicleSimulationConfig config;  // its defaults are scenario S, but for the noise of the controls
  config.vehicle.speed_sigma_m_s = 1.0;
  config.vehicle.steering_sigma_rad = 7.0 * kRadPerDeg;
  config.vehicle.noise_step_s = config.step_s;
  return config;
}

VehicleSimulationConfig grid_survey_stress_config() {
  VehicleSimulationConfig config = grid_survey_config();
  config.step_s = 0.1;
  config.steps_per_scan = 3;
  config.vehicle.noise_step_s = config.step_s;
  return config;
}

VehicleSimulationConfig large_world_config() {
  VehicleSimulationConfig config = grid_survey_config();
  config.step_s = 0.1;
  config.steps_per_scan = 5;
  config.vehicle.speed_sigma_m_s = 0.3;
  config.vehicle.steering_sigma_rad = 2.0 * kRadPerDeg;
  config.vehicle.noise_step_s = config.step_s;
  return config;
}

VehicleSimulationConfig aekf_loop_config() {
  VehicleSimulationConfig config;  // step, speed, range and bearing noise and the steering's stops are its defaults
  config.vehicle.wheelbase_m = 4.0;
  config.vehicle.encoder_offset_m = 0.0;  // a bicycle model, the state at the rear axle
  config.vehicle.reference_forward_m = 0.0;
  config.vehicle.reference_left_m = 0.0;
  config.vehicle.speed_sigma_m_s = 0.3;
  config.vehicle.steering_sigma_rad = 3.0 * kRadPerDeg;
  config.vehicle.noise_step_s = config.step_s;
  config.steps_per_scan = 8;
  config.max_range_m = 30.0;
  return config;
}

}  // namespace ssjs
