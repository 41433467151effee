// Underwater missions: configuration, logs and runs.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <map>

#include "columns.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "run_parts.hpp"
#include "ssjs/io/navigation_log.hpp"
#include "ssjs/pipeline/levelled_run.hpp"

namespace ssjs::bindings {
namespace {

constexpr std::array<const char*, kNavigationSensors> kSensorNames = {"attitude",  "compass", "depth", "altitude", "velocity_log",
                                                                      "side_scan", "fix",     "gyro",  "camera"};

template <std::size_t kSize>
std::vector<double> upper_triangle(const Eigen::Matrix<double, kSize, kSize>& P) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < P.rows(); ++i) {
    for (Eigen::Index j = i; j < P.cols(); ++j) values.push_back(P(i, j));
  }
  return values;
}

py::list submap_list(const LevelledResult& result) {
  std::map<int, int> live_map_of;
  for (const LiveMapEstimate& map : result.live_maps) {
    for (const int member : map.members) live_map_of[member] = map.base;
  }
  py::list list;
  for (const LevelledSubmap& submap : result.submaps) {
    const GaussianSe2& base = result.global_T_base[static_cast<std::size_t>(submap.index)];
    py::dict entry;
    entry["index"] = submap.index;
    entry["start_time_s"] = submap.start_time_s;
    entry["end_time_s"] = submap.end_time_s;
    entry["base_pose"] = Eigen::Vector3d(base.mean.vector());
    entry["base_covariance"] = upper_triangle<3>(base.covariance);
    entry["landmarks"] = submap.landmarks.size();
    entry["live_map"] = live_map_of.at(submap.index);
    entry["link_pose"] = Eigen::Vector3d(submap.mean.head<3>());
    entry["link_covariance"] = upper_triangle<3>(submap.covariance.topLeftCorner<3, 3>());
    entry["closed_because"] = submap.closed_because;
    list.append(entry);
  }
  return list;
}

py::dict landmark_dict(const LevelledResult& result) {
  const auto n = static_cast<Eigen::Index>(result.landmarks.size());
  RowMatrix position(n, 3);
  RowMatrix covariance(n, 6);
  std::vector<std::int64_t> times_seen;
  std::vector<std::int64_t> submap;
  std::vector<std::int64_t> passes_seen;
  std::vector<std::int64_t> passes_expected;
  Eigen::VectorXd existence(n);
  std::vector<bool> confirmed;
  std::vector<std::optional<std::int64_t>> identity;
  py::list maps, tracks;
  std::vector<bool> of_camera;
  for (Eigen::Index i = 0; i < n; ++i) {
    const SurveyLandmark& landmark = result.landmarks[static_cast<std::size_t>(i)];
    const std::vector<double> P = upper_triangle<3>(landmark.covariance);
    position.row(i) = landmark.position;
    for (Eigen::Index j = 0; j < 6; ++j) covariance(i, j) = P[static_cast<std::size_t>(j)];
    times_seen.push_back(landmark.landmark.times_seen);
    submap.push_back(landmark.maps.front());
    passes_seen.push_back(landmark.passes_seen);
    passes_expected.push_back(landmark.passes_expected);
    existence(i) = landmark.existence;
    confirmed.push_back(landmark.confirmed);
    identity.push_back(landmark.landmark.source_id);
    maps.append(landmark.maps);
    tracks.append(landmark.landmark.of_camera ? py::cast(landmark.landmark.tracks) : py::cast(std::vector<std::int64_t>{}));
    of_camera.push_back(landmark.landmark.of_camera);
  }
  py::dict dict;
  dict["position"] = position;
  dict["covariance"] = covariance;
  dict["times_seen"] = array_of(times_seen);
  dict["submap"] = array_of(submap);
  dict["landmark_id"] = identity;
  dict["maps"] = maps;
  dict["tracks"] = tracks;
  dict["of_camera"] = of_camera;
  dict["passes_seen"] = array_of(passes_seen);
  dict["passes_expected"] = array_of(passes_expected);
  dict["existence"] = existence;
  dict["confirmed"] = confirmed;
  dict["joint_covariance"] = result.landmark_covariance.size() > 0 ? py::cast(result.landmark_covariance) : py::none();
  return dict;
}

/// One row a landmark that a frame showed; `landmark` is its track, see `tracks` of the landmarks.
py::dict frame_sighting_dict(const std::vector<FrameSighting>& sightings) {
  const auto n = static_cast<Eigen::Index>(sightings.size());
  Eigen::VectorXd time_s(n);
  RowMatrix measured(n, 2), predicted(n, 2), S(n, 3);
  std::vector<std::int64_t> submap, landmark;
  for (Eigen::Index i = 0; i < n; ++i) {
    const FrameSighting& sighting = sightings[static_cast<std::size_t>(i)];
    time_s(i) = sighting.time_s;
    measured.row(i) = sighting.measured;
    predicted.row(i) = sighting.predicted;
    S.row(i) << sighting.S(0, 0), sighting.S(0, 1), sighting.S(1, 1);
    submap.push_back(sighting.submap);
    landmark.push_back(sighting.track);
  }
  py::dict dict;
  dict["time_s"] = time_s;
  dict["submap"] = array_of(submap);
  dict["landmark"] = array_of(landmark);
  dict["measured_px"] = measured;
  dict["predicted_px"] = predicted;
  dict["innovation_covariance_px2"] = S;
  return dict;
}

py::dict to_python(const LevelledResult& result) {
  py::dict dict;
  dict["time_s"] = result.time_s;
  dict["pose"] = result.pose;
  dict["covariance"] = result.covariance;
  dict["online_pose"] = result.online_pose;
  dict["online_covariance"] = result.online_covariance;
  dict["dead_reckoning"] = result.dead_reckoning;
  dict["submap"] = array_of(result.submap);
  dict["tick_time_s"] = result.tick_time_s;
  dict["step_time_us"] = result.step_time_us;
  dict["landmarks"] = landmark_dict(result);
  dict["updates"] = update_dict(result.updates);
  dict["submaps"] = submap_list(result);
  dict["frame_sightings"] = frame_sighting_dict(result.frame_sightings);
  py::list live_maps;
  for (const LiveMapEstimate& map : result.live_maps) {
    py::dict entry;
    entry["index"] = map.base;
    entry["members"] = map.members;
    entry["landmarks"] = map.landmarks;
    live_maps.append(entry);
  }
  dict["live_maps"] = live_maps;
  dict["loops"] = loop_list(result.loops);
  py::list fixes;
  for (const FixAttempt& fix : result.fixes) {
    py::dict entry;
    entry["time_s"] = fix.time_s;
    entry["base"] = fix.base;
    entry["accepted"] = fix.accepted;
    entry["relocated"] = fix.relocated;
    entry["reason"] = fix.reason;
    entry["chi2"] = fix.chi_squared;
    entry["distance_m"] = fix.distance_m;
    fixes.append(entry);
  }
  dict["fixes"] = fixes;
  dict["joint_base_covariance"] = result.base_covariance.size() > 0 ? py::cast(result.base_covariance) : py::none();
  py::dict sensors;
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    const SensorStatistics& sensor = result.sensors[i];
    py::dict entry;
    entry["used"] = sensor.used;
    entry["refused"] = sensor.refused;
    entry["nis_per_dof"] = sensor.dof > 0 ? py::cast(sensor.nis_sum / sensor.dof) : py::none();
    sensors[kSensorNames[i]] = entry;
  }
  dict["sensors"] = sensors;
  py::dict counters;
  counters["steps"] = result.ticks;
  counters["observations"] = result.observations;
  counters["landmarks"] = result.landmarks.size();
  counters["submaps"] = result.submaps.size();
  counters["loop_candidates"] = result.loop_candidates;
  counters["loop_closures"] = result.loop_closures;
  counters["fusions"] = result.fusions;
  counters["wrong_pairs"] = result.map_identities_known ? py::cast(result.map_wrong_pairs) : py::none();
  counters["scan_wrong_pairs"] = result.scan_wrong_pairs;
  counters["budget_exhausted"] = result.budget_exhausted;
  counters["compass_jumps"] = result.compass_jumps;
  counters["landmarks_merged"] = result.merged;
  counters["unsound_maps"] = result.unsound_maps;
  counters["samples_refused"] = result.refused;
  counters["fusion_dof"] = result.fusion_dof;
  dict["counters"] = counters;
  dict["fusion_chi2"] = result.fusion_chi_squared;
  const double local_s = std::max(0.0, result.time_total_s - result.time_global_s - result.time_association_s);
  py::dict timing;
  timing["time_total_s"] = result.time_total_s;
  timing["time_local_s"] = local_s;
  timing["time_global_s"] = result.time_global_s;
  timing["time_association_s"] = result.time_association_s;
  timing["time_smoothing_s"] = py::none();
  timing["time_other_s"] = 0.0;
  dict["timing"] = timing;
  return dict;
}

py::dict run(const py::dict& config, NavigationLog& log, const std::optional<std::function<bool(double)>>& progress, std::uint64_t seed) {
  const auto levelled = config_from<LevelledConfig>(config);
  const ProgressSink sink = progress_sink(progress);
  LevelledResult result;
  {
    const py::gil_scoped_release released;
    result = run_levelled_mission(levelled, log.ticks(), sink, seed);
  }
  return to_python(result);
}

}  // namespace

void add_levelled(py::module_& module) {
  module.def("levelled_config_fields", &fields_of<LevelledConfig>, "Every configuration key of an underwater mission.");
  module.def(
      "validate_levelled_config", [](const py::dict& values) { return config_from<LevelledConfig>(values).violations(); },
      py::arg("values"), "Every violation of a flat configuration, as text; unknown keys raise ValueError.");

  using Array = py::EigenDRef<const Eigen::MatrixXd>;
  py::class_<NavigationLog>(module, "NavigationLog", "A log of an underwater vehicle, merged by time.")
      .def(py::init<>())
      .def(
          "add_attitude",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& angles) { log.add_attitude(time_s, Eigen::MatrixXd(angles)); },
          py::arg("time_s"), py::arg("roll_pitch_yaw_rad"))
      .def(
          "add_gyro",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& rates) { log.add_gyro(time_s, Eigen::MatrixXd(rates)); },
          py::arg("time_s"), py::arg("body_rates_rad_s"))
      .def(
          "add_depth",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m) { log.add_depth(time_s, depth_m); },
          py::arg("time_s"), py::arg("depth_m"))
      .def(
          "add_altitude",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Eigen::VectorXd& altitude_m) {
            log.add_altitude(time_s, altitude_m);
          },
          py::arg("time_s"), py::arg("altitude_m"))
      .def(
          "add_velocity",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& velocity_m_s, const std::vector<bool>& bottom_lock) {
            log.add_velocity(time_s, Eigen::MatrixXd(velocity_m_s), bottom_lock);
          },
          py::arg("time_s"), py::arg("velocity_m_s"), py::arg("bottom_lock"))
      .def(
          "add_sightings",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& point_m, const std::optional<Eigen::MatrixXd>& covariance,
             const std::optional<std::vector<std::int64_t>>& landmark_id) {
            log.add_sightings(time_s, Eigen::MatrixXd(point_m), covariance.value_or(Eigen::MatrixXd(0, 6)), landmark_id);
          },
          py::arg("time_s"), py::arg("point_m"), py::arg("covariance") = py::none(), py::arg("landmark_id") = py::none(),
          "point_m: n x 3, body frame; covariance: n x 6 upper triangles, or the sensor's; a negative landmark_id means unknown.")
      .def(
          "add_fixes",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& position_m, const Eigen::VectorXd& sigma_m) {
            log.add_fixes(time_s, Eigen::MatrixXd(position_m), sigma_m);
          },
          py::arg("time_s"), py::arg("position_m"), py::arg("sigma_m"), "position_m: n x 2, world frame; sigma_m: of each coordinate.")
      .def(
          "add_frames",
          [](NavigationLog& log, const Eigen::VectorXd& time_s, const Array& pixel, const std::vector<std::int64_t>& count,
             const std::optional<py::EigenDRef<const Eigen::MatrixXf>>& descriptor,
             const std::optional<std::vector<std::int64_t>>& landmark_id) {
            const Eigen::MatrixXf descriptors = descriptor ? Eigen::MatrixXf(*descriptor) : Eigen::MatrixXf(0, 0);
            log.add_frames(time_s, Eigen::MatrixXd(pixel), count, descriptors, landmark_id);
          },
          py::arg("time_s"), py::arg("pixel"), py::arg("count"), py::arg("descriptor") = py::none(), py::arg("landmark_id") = py::none(),
          "pixel: m x 2 (u, v of the corrected frame), those of the first frame first; count: of each frame; descriptor: m x d, float32; a "
          "negative landmark_id means unknown.")
      .def("__len__", [](NavigationLog& log) { return log.ticks().size(); });

  module.def("run_levelled", &run, py::arg("config"), py::arg("log"), py::arg("progress") = py::none(), py::arg("seed") = 1,
             "Runs the log of an underwater vehicle through the pipeline. progress(fraction) -> False asks to stop (KeyboardInterrupt).");
}

}  // namespace ssjs::bindings
