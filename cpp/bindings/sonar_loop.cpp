// The sonar loop with pictures.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "mission_columns.hpp"
#include "parts.hpp"
#include "ssjs/survey/sonar_loop.hpp"

namespace ssjs::bindings {
namespace {

SonarLoopConfig loop_config(const py::dict& values) {
  const auto config = config_from<SonarLoopConfig>(values);
  throw_if_any(config.violations());
  return config;
}

py::dict counts_dict(const SonarLoopCounts& counts) {
  py::dict entry;
  entry["pictures"] = counts.pictures;
  entry["regions"] = counts.regions;
  entry["of_landmarks"] = counts.of_landmarks;
  entry["of_spots"] = counts.of_spots;
  entry["of_nothing"] = counts.of_nothing;
  entry["merged"] = counts.merged;
  entry["second_passes"] = counts.second_passes;
  entry["mean_threshold"] = counts.pictures > 0 ? counts.threshold_sum / static_cast<double>(counts.pictures) : 0.0;
  return entry;
}

py::dict simulate_loop(const std::string& name, const py::dict& values, std::uint64_t seed) {
  const SonarLoopConfig config = loop_config(values);
  Scenario scenario;
  SonarLoopMission made;
  {
    const py::gil_scoped_release unlocked;
    scenario = built_in_scenario(name, seed);
    made = simulate_sonar_loop(scenario, config, seed);
  }
  py::dict dict = mission_columns(made.mission, scenario.config);
  dict["counts"] = counts_dict(made.counts);
  return dict;
}

}  // namespace

void add_sonar_loop(py::module_& module) {
  module.def("sonar_loop_fields", &fields_of<SonarLoopConfig>);
  module.def(
      "validate_sonar_loop", [](const py::dict& values) { return config_from<SonarLoopConfig>(values).violations(); }, py::arg("values"),
      "Every violation of a flat configuration, as text; unknown keys raise ValueError.");
  module.def("simulate_sonar_loop", &simulate_loop, py::arg("scenario"), py::arg("config") = py::dict(), py::arg("seed") = 0,
             "A built-in scenario whose scans are the regions of simulated sonar pictures, and what the pictures came to (counts).");
}

}  // namespace ssjs::bindings
