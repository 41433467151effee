// Detectors.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>

#include <string>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/features/sonar_point_detector.hpp"
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
  module.def(
      "detect_sonar_points",
      [](const Eigen::VectorXd& range_m, const Eigen::VectorXd& bearing_rad, const py::dict& config) {
        if (range_m.size() != bearing_rad.size()) {
          throw InvalidArgument("bearing_rad", std::to_string(bearing_rad.size()) + " rows",
                                "must have as many rows as range_m, " + std::to_string(range_m.size()));
        }
        SonarHits image;
        for (Eigen::Index i = 0; i < range_m.size(); ++i) image.range_bearing.emplace_back(range_m(i), bearing_rad(i));
        const std::vector<SonarPoint> points = detect_sonar_points(image, config_from<SonarPointConfig>(config));
        Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor> rows(static_cast<Eigen::Index>(points.size()), 5);
        for (std::size_t i = 0; i < points.size(); ++i) {
          const SonarPoint& point = points[i];
          rows.row(static_cast<Eigen::Index>(i)) << point.range_bearing.x(), point.range_bearing.y(), static_cast<double>(point.hits),
              point.depth_m, point.width_m;
        }
        return rows;
      },
      py::arg("range_m"), py::arg("bearing_rad"), py::arg("config") = py::dict(),
      "Point targets among the hits of one sonar image: n x 5, range m, bearing rad, hits, depth m, width m.");
}

}  // namespace ssjs::bindings
