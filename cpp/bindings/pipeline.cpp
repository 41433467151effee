// Configuration, logs and runs.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <utility>

#include "columns.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "run_parts.hpp"
#include "ssjs/io/event_log.hpp"
#include "ssjs/pipeline/mission_run.hpp"

namespace ssjs::bindings {
namespace {

std::vector<double> upper_triangle(const Eigen::Matrix3d& P) { return {P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2)}; }
std::vector<double> numbers(const Se2& pose) { return {pose.x, pose.y, pose.heading}; }

py::list submap_list(const MissionResult& result) {
  std::map<int, int> live_map_of;
  for (const LiveMapEstimate& map : result.world.maps) {
    for (const int member : map.members) live_map_of[member] = map.base;
  }
  py::list list;
  for (const Submap& submap : result.submaps) {
    const auto k = static_cast<std::size_t>(submap.index);
    py::dict entry;
    entry["index"] = submap.index;
    entry["start_time_s"] = submap.start_time_s;
    entry["end_time_s"] = submap.end_time_s;
    entry["base_pose"] = numbers(result.world.global_T_base[k]);
    entry["base_covariance"] = upper_triangle(result.world.border_covariance[k].topLeftCorner<3, 3>());
    entry["landmarks"] = submap.landmarks.size();
    entry["live_map"] = live_map_of.at(submap.index);
    entry["link_pose"] = numbers(submap.state.vehicle().mean);
    entry["link_covariance"] = upper_triangle(submap.state.vehicle().covariance);
    entry["closed_because"] = submap.closed_because;
    list.append(entry);
  }
  return list;
}

py::dict landmark_dict(const MissionResult& result) {
  const auto n = static_cast<Eigen::Index>(result.world.landmarks.size());
  RowMatrix position(n, 2);
  RowMatrix covariance(n, 3);
  std::vector<std::int64_t> times_seen;
  std::vector<std::int64_t> submap;
  std::vector<std::optional<std::int64_t>> identity;
  for (Eigen::Index i = 0; i < n; ++i) {
    const LandmarkEstimate& landmark = result.world.landmarks[static_cast<std::size_t>(i)];
    const Eigen::Matrix2d& P = landmark.position.covariance;
    position.row(i) = landmark.position.mean;
    covariance.row(i) << P(0, 0), P(0, 1), P(1, 1);
    times_seen.push_back(landmark.landmark.times_seen);
    submap.push_back(landmark.base);
    identity.push_back(landmark.landmark.source_id);
  }
  py::dict dict;
  dict["position"] = position;
  dict["covariance"] = covariance;
  dict["times_seen"] = array_of(times_seen);
  dict["submap"] = array_of(submap);
  dict["landmark_id"] = identity;
  return dict;
}

py::dict to_python(const MissionResult& result) {
  py::dict dict;
  dict["time_s"] = result.time_s;
  dict["pose"] = result.pose;
  dict["covariance"] = result.covariance;
  dict["online_pose"] = result.online_pose;
  dict["online_covariance"] = result.online_covariance;
  dict["dead_reckoning"] = result.dead_reckoning;
  dict["submap"] = array_of(result.submap);
  dict["step_time_us"] = result.step_time_us;
  dict["landmarks"] = landmark_dict(result);
  dict["updates"] = update_dict(result.updates);
  dict["submaps"] = submap_list(result);
  py::list maps;
  for (const LiveMapEstimate& map : result.world.maps) {
    py::dict entry;
    entry["index"] = map.base;
    entry["members"] = map.members;
    entry["landmarks"] = map.landmarks;
    maps.append(entry);
  }
  dict["live_maps"] = maps;
  dict["loops"] = loop_list(result.loops);
  const Eigen::MatrixXd& joint = result.world.base_covariance;
  dict["joint_base_covariance"] = joint.size() > 0 ? py::cast(joint) : py::none();
  py::dict counters;
  counters["steps"] = result.time_s.size();
  counters["observations"] = result.observations;
  counters["landmarks"] = result.world.landmarks.size();
  counters["submaps"] = result.submaps.size();
  counters["loop_candidates"] = result.loop_candidates;
  counters["loop_closures"] = result.loop_closures;
  counters["fusions"] = result.fusions;
  counters["wrong_pairs"] = result.map_identities_known ? py::cast(result.map_wrong_pairs) : py::none();
  counters["scan_wrong_pairs"] = result.scan_wrong_pairs;
  counters["budget_exhausted"] = result.budget_exhausted;
  counters["fusion_dof"] = result.fusion_dof;
  if (result.smoothing) {
    counters["half_chi2_initial"] = result.smoothing->half_chi_squared_initial;
    counters["half_chi2_final"] = result.smoothing->half_chi_squared_final;
    counters["smoothing_iterations"] = result.smoothing->iterations;
    counters["smoothing_converged"] = result.smoothing->converged;
    counters["smoothing_poses"] = result.smoothing->poses;
    counters["smoothing_sightings"] = result.smoothing->sightings;
    counters["smoothing_factor_entries"] = result.smoothing->factor_entries;
    counters["smoothing_doubted"] = result.smoothing->doubted;
  }
  dict["counters"] = counters;
  dict["fusion_chi2"] = result.fusion_chi_squared;
  py::dict timing;
  timing["time_total_s"] = result.time_total_s;
  timing["time_local_s"] = result.time_local_s;
  timing["time_global_s"] = result.time_global_s;
  timing["time_association_s"] = result.time_association_s;
  timing["time_smoothing_s"] = result.smoothing ? py::cast(result.time_smoothing_s) : py::none();
  timing["time_other_s"] =
      std::max(0.0, result.time_total_s - result.time_local_s - result.time_global_s - result.time_association_s - result.time_smoothing_s);
  dict["timing"] = timing;
  return dict;
}

py::dict run(const py::dict& config, EventLog& log, std::uint64_t seed, const std::optional<std::function<bool(double)>>& progress) {
  const auto slam = config_from<SlamConfig>(config);
  const ProgressSink sink = progress_sink(progress);
  MissionResult result;
  {
    const py::gil_scoped_release released;
    result = run_mission(slam, log.events(), seed, sink);
  }
  return to_python(result);
}

py::tuple pose_tuple(const GaussianSe2& pose) {
  return py::make_tuple(Eigen::Vector3d(pose.mean.vector()), Eigen::Matrix3d(pose.covariance));
}

}  // namespace

void add_pipeline(py::module_& module) {
  module.def("config_fields", &fields_of<SlamConfig>, "Every configuration key: key, type, default, choices, rule, description.");
  module.def(
      "validate_config", [](const py::dict& values) { return config_from<SlamConfig>(values).violations(); }, py::arg("values"),
      "Every violation of a flat configuration, as text; unknown keys raise ValueError.");

  using Array = py::EigenDRef<const Eigen::MatrixXd>;
  py::class_<EventLog>(module, "MissionLog", "A log of odometry and observations, merged by time.")
      .def(py::init<>())
      .def("add_ackerman", &EventLog::add_ackerman, py::arg("time_s"), py::arg("speed_m_s"), py::arg("steering_rad"))
      .def("add_velocity", &EventLog::add_velocity, py::arg("time_s"), py::arg("speed_m_s"), py::arg("turn_rate_rad_s"))
      .def(
          "add_increments",
          [](EventLog& log, const Eigen::VectorXd& time_s, const Eigen::VectorXd& dx, const Eigen::VectorXd& dy,
             const Eigen::VectorXd& dheading,
             const Array& covariance) { log.add_increments(time_s, dx, dy, dheading, Eigen::MatrixXd(covariance)); },
          py::arg("time_s"), py::arg("dx_m"), py::arg("dy_m"), py::arg("dheading_rad"), py::arg("covariance"))
      .def(
          "add_features",
          [](EventLog& log, const Eigen::VectorXd& time_s, const Eigen::VectorXd& range_m, const Eigen::VectorXd& bearing_rad,
             const Array& covariance, const std::optional<std::vector<std::int64_t>>& landmark_id) {
            log.add_features(time_s, range_m, bearing_rad, Eigen::MatrixXd(covariance), landmark_id);
          },
          py::arg("time_s"), py::arg("range_m"), py::arg("bearing_rad"), py::arg("covariance"), py::arg("landmark_id") = py::none(),
          "covariance: n x 3 (var range, cov, var bearing); a negative landmark_id means unknown.")
      .def(
          "add_scans",
          [](EventLog& log, const Eigen::VectorXd& time_s, const Array& range_m, double first_angle_rad, double step_rad) {
            log.add_scans(time_s, Eigen::MatrixXd(range_m), first_angle_rad, step_rad);
          },
          py::arg("time_s"), py::arg("range_m"), py::arg("first_angle_rad"), py::arg("step_rad"))
      .def("add_sonar_hits", &EventLog::add_sonar_hits, py::arg("time_s"), py::arg("range_m"), py::arg("bearing_rad"),
           "Hits of a forward-looking sonar; consecutive rows of equal time form one image.")
      .def("__len__", [](EventLog& log) { return log.events().size(); });

  module.def("run", &run, py::arg("config"), py::arg("log"), py::arg("seed") = 0, py::arg("progress") = py::none(),
             "Runs a log through the pipeline. progress(fraction) -> False asks to stop (KeyboardInterrupt).");

  py::class_<SlamPipeline>(module, "Pipeline", "The pipeline fed one event at a time.")
      .def(py::init([](const py::dict& config, std::uint64_t seed) {
             return std::make_unique<SlamPipeline>(config_from<SlamConfig>(config), seed);
           }),
           py::arg("config"), py::arg("seed") = 0)
      .def(
          "feed_ackerman",
          [](SlamPipeline& pipeline, double time_s, double speed_m_s, double steering_rad) {
            return pose_tuple(pipeline.feed({time_s, AckermanControl{speed_m_s, steering_rad}}).global_T_vehicle);
          },
          py::arg("time_s"), py::arg("speed_m_s"), py::arg("steering_rad"), "Pose (3,) and covariance (3, 3) after the event.")
      .def(
          "feed_velocity",
          [](SlamPipeline& pipeline, double time_s, double speed_m_s, double turn_rate_rad_s) {
            return pose_tuple(pipeline.feed({time_s, VelocityControl{speed_m_s, turn_rate_rad_s}}).global_T_vehicle);
          },
          py::arg("time_s"), py::arg("speed_m_s"), py::arg("turn_rate_rad_s"), "Pose (3,) and covariance (3, 3) after the event.")
      .def(
          "feed_features",
          [](SlamPipeline& pipeline, double time_s, const Eigen::VectorXd& range_m, const Eigen::VectorXd& bearing_rad,
             const Array& covariance, const std::optional<std::vector<std::int64_t>>& landmark_id) {
            EventLog scan;
            scan.add_features(Eigen::VectorXd::Constant(range_m.size(), time_s), range_m, bearing_rad, Eigen::MatrixXd(covariance),
                              landmark_id);
            for (const Event& event : scan.events()) pipeline.feed(event);
            return pose_tuple(pipeline.global_T_vehicle());
          },
          py::arg("time_s"), py::arg("range_m"), py::arg("bearing_rad"), py::arg("covariance"), py::arg("landmark_id") = py::none(),
          "One scan; pose (3,) and covariance (3, 3) after it.")
      .def("pose", [](const SlamPipeline& pipeline) { return pose_tuple(pipeline.global_T_vehicle()); })
      .def("finish", [](SlamPipeline& pipeline) { pipeline.finish(); });
}

}  // namespace ssjs::bindings
