// Errors and consistency.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "config.hpp"
#include "parts.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/evaluation/consistency.hpp"
#include "ssjs/evaluation/map_error.hpp"
#include "ssjs/evaluation/trajectory_error.hpp"

namespace ssjs::bindings {
namespace {

using Array = py::EigenDRef<const Eigen::MatrixXd>;

void check_columns(const char* what, Eigen::Index columns, Eigen::Index expected) {
  if (columns == expected) return;
  throw InvalidArgument(what, std::to_string(columns) + " columns", "must have " + std::to_string(expected));
}

Alignment alignment_of(const std::string& name) {
  if (name == "none") return Alignment::kNone;
  if (name == "origin") return Alignment::kOrigin;
  if (name == "yaw") return Alignment::kYaw;
  if (name == "se2") return Alignment::kSe2;
  throw InvalidArgument("alignment", name, "must be none, origin, yaw or se2 for a vehicle in the plane");
}

std::vector<double> seconds(const Eigen::VectorXd& values) { return {values.data(), values.data() + values.size()}; }

py::object trajectory_error_of(const Eigen::VectorXd& time_s, const Array& pose, const Eigen::VectorXd& fix_time_s,
                               const Array& fix_position, const std::optional<Eigen::VectorXd>& fix_heading,
                               const Eigen::Vector2d& lever_arm, const std::string& alignment, std::optional<double> outlier_m,
                               double max_gap_s) {
  check_columns("pose", pose.cols(), 3);
  check_columns("fix_position", fix_position.cols(), 2);
  Trajectory estimate{seconds(time_s), {}};
  for (Eigen::Index i = 0; i < pose.rows(); ++i) estimate.global_T_vehicle.push_back(Se2::from_vector(pose.row(i).transpose()));
  ReferenceFixes reference;
  reference.time_s = seconds(fix_time_s);
  reference.position_m = fix_position.transpose();
  reference.heading_rad = fix_heading;
  reference.vehicle_p_antenna = lever_arm;
  const TrajectoryErrorConfig config{alignment_of(alignment), outlier_m, max_gap_s};
  const auto error = trajectory_error(estimate, reference, config);
  if (!error) return py::none();
  py::dict dict;
  dict["compared"] = error->compared;
  dict["outliers"] = error->outliers;
  dict["rmse_m"] = error->rmse_m;
  dict["mean_m"] = error->mean_m;
  dict["std_m"] = error->std_m;
  dict["max_m"] = error->max_m;
  dict["median_m"] = error->median_m;
  dict["heading_rmse_rad"] = error->heading_rmse_rad;
  dict["final_error_m"] = error->final_error_m;
  dict["path_length_m"] = error->path_length_m;
  dict["final_drift_percent"] = error->final_drift_percent;
  dict["reference_T_estimate"] = Eigen::Vector3d(error->reference_T_estimate.vector());
  dict["time_s"] = py::array(py::cast(error->time_s));
  dict["error_m"] = py::array(py::cast(error->error_m));
  dict["is_outlier"] = py::array(py::cast(error->is_outlier));
  return dict;
}

py::object map_error_of(const Array& estimated, const std::vector<std::optional<std::int64_t>>& estimated_ids, const Array& truth,
                        const std::vector<std::int64_t>& truth_ids, double max_distance_m, bool align) {
  check_columns("estimated", estimated.cols(), 2);
  check_columns("truth", truth.cols(), 2);
  const auto error = map_error(estimated.transpose(), estimated_ids, truth.transpose(), truth_ids, {max_distance_m, align});
  if (!error) return py::none();
  py::dict dict;
  dict["matched"] = error->matched;
  dict["missed"] = error->missed;
  dict["false_landmarks"] = error->false_landmarks;
  dict["mean_m"] = error->mean_m;
  dict["std_m"] = error->std_m;
  dict["max_m"] = error->max_m;
  dict["rmse_m"] = error->rmse_m;
  dict["truth_of"] = error->truth_of;
  return dict;
}

}  // namespace

void add_evaluation(py::module_& module) {
  module.def("trajectory_error", &trajectory_error_of, py::arg("time_s"), py::arg("pose"), py::arg("fix_time_s"), py::arg("fix_position"),
             py::arg("fix_heading") = py::none(), py::arg("lever_arm") = Eigen::Vector2d(0.0, 0.0), py::arg("alignment") = "se2",
             py::arg("outlier_m") = py::none(), py::arg("max_gap_s") = 1.0, "Errors against fixes; None when nothing can be compared.");
  module.def("map_error", &map_error_of, py::arg("estimated"), py::arg("estimated_ids"), py::arg("truth"), py::arg("truth_ids"),
             py::arg("max_distance_m") = 10.0, py::arg("align") = false, "Errors against surveyed landmarks; None when nothing matches.");
  module.def(
      "consistency_summary",
      [](const std::vector<double>& values, const std::vector<int>& dof) {
        const ConsistencySummary summary = summarize(values, dof);
        py::dict dict;
        dict["samples"] = summary.samples;
        dict["mean"] = summary.mean;
        dict["mean_per_dof"] = summary.mean_per_dof;
        dict["inside_fraction"] = summary.inside_fraction;
        dict["above_fraction"] = summary.above_fraction;
        return dict;
      },
      py::arg("values"), py::arg("dof"));
  module.def(
      "mean_band",
      [](double dof, int samples, double probability) {
        const Band band = mean_band(dof, samples, probability);
        return py::make_tuple(band.lower, band.upper);
      },
      py::arg("dof"), py::arg("samples"), py::arg("probability") = 0.95);
  module.def("chi_squared_quantile", &chi_squared_quantile, py::arg("probability"), py::arg("dof"));
  module.def(
      "normalized_squared_error",
      [](const Eigen::VectorXd& error, const Array& covariance) { return normalized_squared_error(error, Eigen::MatrixXd(covariance)); },
      py::arg("error"), py::arg("covariance"));
}

}  // namespace ssjs::bindings
