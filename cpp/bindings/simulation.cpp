// The built-in scenarios.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "columns.hpp"
#include "config.hpp"
#include "mission_columns.hpp"
#include "parts.hpp"
#include "ssjs/simulation/scenario.hpp"

namespace ssjs::bindings {
namespace {

using PointRows = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

}  // namespace

py::dict mission_columns(const SimulatedMission& mission, const VehicleSimulationConfig& simulated) {
  std::vector<double> control_time_s, speed_m_s, steering_rad, scan_time_s, range_m, bearing_rad, covariance;
  std::vector<std::int64_t> landmark_id;
  for (const Event& event : mission.events) {
    if (const auto* control = std::get_if<AckermanControl>(&event.record)) {
      control_time_s.push_back(event.time_s);
      speed_m_s.push_back(control->speed_m_s);
      steering_rad.push_back(control->steering_rad);
    } else if (const auto* scan = std::get_if<Features>(&event.record)) {
      for (const Feature& feature : *scan) {
        scan_time_s.push_back(event.time_s);
        range_m.push_back(feature.range());
        bearing_rad.push_back(feature.bearing());
        landmark_id.push_back(feature.landmark_id.value_or(-1));
        const Eigen::Matrix2d& R = feature.covariance;
        covariance.insert(covariance.end(), {R(0, 0), R(0, 1), R(1, 1)});
      }
    }
  }
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> truth(static_cast<Eigen::Index>(mission.time_s.size()), 3);
  for (std::size_t i = 0; i < mission.time_s.size(); ++i) truth.row(static_cast<Eigen::Index>(i)) = mission.global_T_vehicle[i].vector();

  py::dict config;  // the noise of the simulation is the noise the filter should assume
  const AckermanConfig& vehicle = simulated.vehicle;
  config["vehicle.kind"] = "ackerman";
  config["vehicle.ackerman.wheelbase_m"] = vehicle.wheelbase_m;
  config["vehicle.ackerman.encoder_offset_m"] = vehicle.encoder_offset_m;
  config["vehicle.ackerman.reference_forward_m"] = vehicle.reference_forward_m;
  config["vehicle.ackerman.reference_left_m"] = vehicle.reference_left_m;
  config["vehicle.ackerman.speed_sigma_m_s"] = vehicle.speed_sigma_m_s;
  config["vehicle.ackerman.steering_sigma_rad"] = vehicle.steering_sigma_rad;
  config["vehicle.ackerman.lateral_sigma_m_s"] = vehicle.lateral_sigma_m_s;
  config["vehicle.ackerman.noise_step_s"] = vehicle.noise_step_s;
  config["sensor.range_sigma_m"] = simulated.range_sigma_m;
  config["sensor.bearing_sigma_rad"] = simulated.bearing_sigma_rad;

  py::dict dict;
  dict["control_time_s"] = array_of(control_time_s);
  dict["speed_m_s"] = array_of(speed_m_s);
  dict["steering_rad"] = array_of(steering_rad);
  dict["scan_time_s"] = array_of(scan_time_s);
  dict["range_m"] = array_of(range_m);
  dict["bearing_rad"] = array_of(bearing_rad);
  dict["landmark_id"] = array_of(landmark_id);
  using CovarianceRows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  dict["covariance"] = CovarianceRows(Eigen::Map<const CovarianceRows>(covariance.data(), static_cast<Eigen::Index>(range_m.size()), 3));
  dict["truth_time_s"] = array_of(mission.time_s);
  dict["truth_pose"] = truth;
  dict["landmark_position"] = PointRows(mission.world.landmarks_m.transpose());
  dict["landmark_ids"] = array_of(mission.world.ids);
  dict["config"] = config;
  return dict;
}

namespace {

py::dict simulate_scenario(const std::string& name, std::uint64_t seed) {
  Scenario scenario;
  SimulatedMission mission;
  {
    const py::gil_scoped_release released;
    scenario = built_in_scenario(name, seed);
    mission = simulate(scenario.world, scenario.config, seed);
  }
  py::dict dict = mission_columns(mission, scenario.config);
  dict["config"]["joining.max_pairing_sigma_m"] = 0.8;  // a regular grid of 5 m aliases by one cell: 0.16 of the spacing
  return dict;
}

py::dict simulate_world(const py::EigenDRef<const Eigen::MatrixXd>& landmarks, const std::vector<std::int64_t>& ids,
                        const py::EigenDRef<const Eigen::MatrixXd>& waypoints, const py::dict& values, std::uint64_t seed) {
  for (const auto* points : {&landmarks, &waypoints}) {
    if (points->cols() != 2) throw InvalidArgument("points", std::to_string(points->cols()) + " columns", "must have x and y");
  }
  World world;
  world.landmarks_m = landmarks.transpose();
  world.ids = ids;
  for (Eigen::Index i = 0; i < waypoints.rows(); ++i) world.waypoints.emplace_back(waypoints(i, 0), waypoints(i, 1));
  const auto config = config_from<VehicleSimulationConfig>(values);
  SimulatedMission mission;
  {
    const py::gil_scoped_release released;
    mission = simulate(world, config, seed);
  }
  return mission_columns(mission, config);
}

}  // namespace

void add_simulation(py::module_& module) {
  module.def("scenario_names", &scenario_names);
  module.def("simulate", &simulate_scenario, py::arg("scenario"), py::arg("seed") = 0,
             "A built-in scenario: measured log, truth, filter settings.");
  module.def("simulate_world", &simulate_world, py::arg("landmarks"), py::arg("ids"), py::arg("waypoints"), py::arg("config"),
             py::arg("seed") = 0, "The same for landmarks (n x 2) and waypoints (m x 2) in one frame; config as in simulation_fields().");
  module.def(
      "simulation_fields",
      [] {
        VehicleSimulationConfig config;
        FieldLister lister;
        config.visit(lister);
        return lister.fields();
      },
      "Every key of a simulated drive: key, type, default, choices, rule, description.");
  module.def(
      "validate_simulation", [](const py::dict& values) { return violations(config_from<VehicleSimulationConfig>(values)); },
      py::arg("values"), "Every violation of a flat simulation configuration, as text; unknown keys raise ValueError.");
  module.def(
      "grid_field",
      [](int columns, int rows, double spacing_m, double jitter_m, std::uint64_t seed) {
        return PointRows(grid_field(columns, rows, spacing_m, jitter_m, seed).landmarks_m.transpose());
      },
      py::arg("columns"), py::arg("rows"), py::arg("spacing_m"), py::arg("jitter_m"), py::arg("seed"), "Landmarks (n x 2).");
  module.def(
      "random_field",
      [](int count, double width_m, double height_m, double min_distance_m, std::uint64_t seed) {
        return PointRows(random_field(count, width_m, height_m, min_distance_m, seed).landmarks_m.transpose());
      },
      py::arg("count"), py::arg("width_m"), py::arg("height_m"), py::arg("min_distance_m"), py::arg("seed"), "Landmarks (n x 2).");
}

}  // namespace ssjs::bindings
