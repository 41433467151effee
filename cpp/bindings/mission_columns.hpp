/// A simulated mission of a vehicle in the plane as columns.
#pragma once

#include <pybind11/pybind11.h>

#include "ssjs/simulation/vehicle_simulator.hpp"

namespace ssjs::bindings {

/// The log in columns, the truth, and the settings that a filter of the same mind has.
[[nodiscard]] pybind11::dict mission_columns(const SimulatedMission& mission, const VehicleSimulationConfig& simulated);

}  // namespace ssjs::bindings
