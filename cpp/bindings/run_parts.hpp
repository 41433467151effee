/// What runs on land and under water give to Python alike.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <optional>
#include <vector>

#include "ssjs/pipeline/mission_run.hpp"

namespace ssjs::bindings {

namespace py = pybind11;

[[nodiscard]] py::list loop_list(const std::vector<LoopAttempt>& loops);
/// time_s, nis, dof: one row an update.
[[nodiscard]] py::dict update_dict(const std::vector<MissionResult::Update>& updates);
/// Asks `progress` with the interpreter locked; a signal that came in between is raised.
[[nodiscard]] ProgressSink progress_sink(const std::optional<std::function<bool(double)>>& progress);

}  // namespace ssjs::bindings
