/// One function a folder of the library.
#pragma once

#include <pybind11/pybind11.h>

namespace ssjs::bindings {

void add_pipeline(pybind11::module_& module);
void add_levelled(pybind11::module_& module);
void add_evaluation(pybind11::module_& module);
void add_simulation(pybind11::module_& module);
void add_underwater_simulation(pybind11::module_& module);
void add_features(pybind11::module_& module);
void add_imaging(pybind11::module_& module);
void add_segmentation(pybind11::module_& module);
void add_optical(pybind11::module_& module);
void add_visual_odometry(pybind11::module_& module);
void add_mosaic(pybind11::module_& module);
void add_cascade(pybind11::module_& module);
void add_survey(pybind11::module_& module);
void add_sonar_loop(pybind11::module_& module);
void add_season(pybind11::module_& module);
void add_io(pybind11::module_& module);

}  // namespace ssjs::bindings
