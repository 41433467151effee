// Detectors.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/features/tree_detector.hpp"

namespace ssjs::bindings {

void add_features(py::module_& module) {
  module.def(
      "detect_trunks",
      [](const Eigen::VectorXd& range_m, double first_angle_rad, double step_rad, const py::dict& config) {
        const auto trees = config_from<TreeDetectorConfig>(config);
        throw_if_any(violations(trees));
        const std::vector<Trunk> trunks = detect_trunks({range_m, first_angle_rad, step_rad}, trees);
        Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> rows(static_cast<Eigen::Index>(trunks.size()), 3);
        for (std::size_t i = 0; i < trunks.size(); ++i) {
          rows.row(static_cast<Eigen::Index>(i)) << trunks[i].range_m, trunks[i].bearing_rad, trunks[i].diameter_m;
        }
        return rows;
      },
      py::arg("range_m"), py::arg("first_angle_rad"), py::arg("step_rad"), py::arg("config") = py::dict(),
      "Trunks of one scan: n x 3, range m, bearing rad, diameter m.");
}

}  // namespace ssjs::bindings
