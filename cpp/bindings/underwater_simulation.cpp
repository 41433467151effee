// Simulated underwater surveys: navigation, sightings or pings, and the truth.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "columns.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "run_parts.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/optical/lens.hpp"
#include "ssjs/simulation/auv_survey.hpp"
#include "ssjs/simulation/camera_survey.hpp"
#include "ssjs/simulation/shared_seabed.hpp"
#include "ssjs/simulation/side_scan_mission.hpp"

namespace ssjs::bindings {
namespace {

/// Columns of numbers that grow row by row.
class Table {
 public:
  explicit Table(py::ssize_t columns) : columns_(columns) {}
  void add(const std::vector<double>& row) { values_.insert(values_.end(), row.begin(), row.end()); }
  [[nodiscard]] py::array array() const {
    return py::array_t<double>({static_cast<py::ssize_t>(values_.size()) / columns_, columns_}, values_.data());
  }

 private:
  py::ssize_t columns_;
  std::vector<double> values_;
};

py::dict survey_dict(const SimulatedSurvey& survey) {
  Table attitude(4), gyro(4), velocity(5), depth(2), altitude(2), fixes(4), sightings(4), truth(7), landmarks(3);
  std::vector<std::int64_t> ids;
  for (const NavigationTick& tick : survey.ticks) {
    const double t = tick.time_s;
    if (tick.roll_pitch_rad && tick.compass_rad) {  // one record of the attitude sensor: it is there whole or not at all
      attitude.add({t, tick.roll_pitch_rad->x(), tick.roll_pitch_rad->y(), *tick.compass_rad});
      if (tick.gyro_rad_s) gyro.add({t, tick.gyro_rad_s->x(), tick.gyro_rad_s->y(), tick.gyro_rad_s->z()});
    }
    if (tick.velocity) {
      const Eigen::Vector3d& v = tick.velocity->velocity_m_s;
      velocity.add({t, v.x(), v.y(), v.z(), tick.velocity->bottom_lock ? 1.0 : 0.0});
    }
    if (tick.depth_m) depth.add({t, *tick.depth_m});
    if (tick.altitude_m) altitude.add({t, *tick.altitude_m});
    if (tick.fix) fixes.add({t, tick.fix->world_p_vehicle.x(), tick.fix->world_p_vehicle.y(), std::sqrt(tick.fix->covariance(0, 0))});
    for (const SideScanSighting& sighting : tick.sightings) {
      const Eigen::Vector3d& p = sighting.vehicle_p_point;
      sightings.add({t, p.x(), p.y(), p.z()});
      ids.push_back(sighting.landmark_id.value_or(-1));
    }
  }
  for (const AuvTruth& at : survey.truth) {
    const Vector6d pose = at.world_T_vehicle.vector();
    truth.add({at.time_s, pose(0), pose(1), pose(2), pose(3), pose(4), pose(5)});
  }
  for (Eigen::Index i = 0; i < survey.world.landmarks_m.cols(); ++i) {
    landmarks.add({survey.world.landmarks_m(0, i), survey.world.landmarks_m(1, i), survey.world.landmarks_m(2, i)});
  }
  py::dict dict;
  dict["attitude"] = attitude.array();
  dict["gyro"] = gyro.array();
  dict["velocity"] = velocity.array();
  dict["depth"] = depth.array();
  dict["altitude"] = altitude.array();
  dict["fixes"] = fixes.array();
  dict["sightings"] = sightings.array();
  dict["sighting_ids"] = array_of(ids);
  dict["truth"] = truth.array();
  dict["landmarks"] = landmarks.array();
  dict["landmark_ids"] = array_of(survey.world.ids);
  return dict;
}

py::dict simulate_auv_survey(std::uint64_t seed, const py::dict& vehicle, const py::dict& lines) {
  const auto simulated = config_from<AuvSimulationConfig>(vehicle);
  const auto world = config_from<SurveyWorldConfig>(lines);
  SimulatedSurvey survey;
  {
    const py::gil_scoped_release released;
    survey = simulate_survey(survey_world(world, seed), simulated, seed);
  }
  return survey_dict(survey);
}

py::dict simulate_on_shared_seabed(std::uint64_t seed, const py::dict& vehicle, const py::dict& lines, const py::dict& seabed) {
  auto simulated = config_from<AuvSimulationConfig>(vehicle);
  const PlacedSurvey placed = survey_on_shared_seabed(config_from<SharedSeabedConfig>(seabed), config_from<SurveyWorldConfig>(lines), seed);
  simulated.compass_offset_rad = placed.compass_offset_rad;
  SimulatedSurvey survey;
  {
    const py::gil_scoped_release released;
    survey = simulate_survey(placed.world, simulated, seed);
  }
  py::dict dict = survey_dict(survey);
  dict["start_m"] = placed.seabed_p_start;
  dict["origin_m"] = placed.seabed_p_origin;
  dict["seabed_landmarks"] = RowMatrix(placed.seabed_p_landmarks.transpose());
  return dict;
}

SideScanMission side_scan_mission(const py::dict& values, std::uint64_t seed) {
  const SideScanMissionConfig defaults;
  const auto config = config_from(values, defaults);
  const py::gil_scoped_release released;
  return {config, seed};
}

/// The samples of one side, nearest first: one row a ping.
py::array_t<float> samples_of(const std::vector<SideScanPing>& pings, SonarSide side) {
  std::size_t count = 0;
  std::vector<const SideScanChannel*> rows;
  for (const SideScanPing& ping : pings) {
    for (const SideScanChannel& channel : ping.channels) {
      if (channel.side != side) continue;
      rows.push_back(&channel);
      count = channel.samples.size();
    }
  }
  py::array_t<float> array({static_cast<py::ssize_t>(rows.size()), static_cast<py::ssize_t>(count)});
  float* to = array.mutable_data();
  for (const SideScanChannel* row : rows) to = std::copy(row->samples.begin(), row->samples.end(), to);
  return array;
}

/// None at the end of the mission.
py::object next_pings(SideScanMission& mission, std::size_t most) {
  std::vector<SideScanPing> pings;
  {
    const py::gil_scoped_release released;
    while (pings.size() < most) {
      std::optional<SideScanPing> ping = mission.next_ping();
      if (!ping) break;
      pings.push_back(std::move(*ping));
    }
  }
  if (pings.empty()) return py::none();
  Table navigation(7);
  for (const SideScanPing& ping : pings) {
    navigation.add({ping.time_s, ping.roll_rad, ping.pitch_rad, ping.heading_rad, ping.speed_m_s, ping.depth_m, ping.altitude_m});
  }
  const SideScanPing& first = pings.front();
  const SideScanChannel& channel = first.channels.front();
  py::dict block;
  block["first_number"] = first.number;
  block["navigation"] = navigation.array();
  block["port"] = samples_of(pings, SonarSide::kPort);
  block["starboard"] = samples_of(pings, SonarSide::kStarboard);
  block["sound_speed_m_s"] = first.sound_speed_m_s;
  block["frequency_hz"] = channel.frequency_hz;
  block["sample_interval_s"] = channel.sample_interval_s;
  return std::move(block);
}

CameraCalibration calibration_of(const SimulatedCameraConfig& camera) {
  CameraCalibration calibration;
  calibration.camera = camera.pinhole();
  calibration.lens = camera.lens_k1 == 0.0 && camera.lens_k2 == 0.0 ? LensModel::kPinhole : LensModel::kBrown;
  calibration.distortion = {camera.lens_k1, camera.lens_k2, 0.0, 0.0, 0.0};
  return calibration;
}

CameraRays rays_of(const CameraCalibration& calibration) {
  check_calibration(calibration);
  const PinholeCamera& camera = calibration.camera;
  CameraRays rays{camera.width_px, camera.height_px, {}};
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const cv::Point2d ideal = undistorted(calibration, {static_cast<double>(u), static_cast<double>(v)});
      rays.slopes.emplace_back(static_cast<float>((ideal.x - camera.centre_x_px) / camera.focal_x_px),
                               static_cast<float>((ideal.y - camera.centre_y_px) / camera.focal_y_px));
    }
  }
  return rays;
}

/// With the camera, as its calibration file says it.
struct PhotographedSurvey {
  CameraCalibration calibration;
  CameraSurvey survey;

  PhotographedSurvey(const CameraSurveyConfig& config, std::uint64_t seed)
      : calibration(calibration_of(config.camera)), survey(config, rays_of(calibration), seed) {}
};

std::unique_ptr<PhotographedSurvey> camera_survey(const py::dict& values, std::uint64_t seed) {
  const auto config = config_from<CameraSurveyConfig>(values);
  throw_if_any(violations(config));
  const py::gil_scoped_release released;
  return std::make_unique<PhotographedSurvey>(config, seed);
}

py::array_t<std::uint8_t> rendered_frame(const PhotographedSurvey& of, int number) {
  const PinholeCamera& camera = of.calibration.camera;
  py::array_t<std::uint8_t> frame({camera.height_px, camera.width_px, 3});
  std::vector<std::uint8_t> pixels;
  {
    const py::gil_scoped_release released;
    pixels = of.survey.frame(number);
  }
  std::copy(pixels.begin(), pixels.end(), frame.mutable_data());
  return frame;
}

py::dict camera_of(const PhotographedSurvey& of) {
  const CameraCalibration& calibration = of.calibration;
  py::dict camera;
  camera["width_px"] = calibration.camera.width_px;
  camera["height_px"] = calibration.camera.height_px;
  camera["focal_x_px"] = calibration.camera.focal_x_px;
  camera["focal_y_px"] = calibration.camera.focal_y_px;
  camera["centre_x_px"] = calibration.camera.centre_x_px;
  camera["centre_y_px"] = calibration.camera.centre_y_px;
  camera["lens"] = calibration.lens == LensModel::kBrown ? "brown" : "pinhole";
  camera["distortion"] = calibration.lens == LensModel::kBrown ? py::tuple(py::cast(calibration.distortion)) : py::tuple();
  return camera;
}

/// Depths on a grid, for whoever asks where a pixel of a frame truly lies.
py::dict relief_of(const PhotographedSurvey& of) {
  const Raster<SurfacePatch>& relief = of.survey.seabed().relief();
  py::array_t<float> depth_m({relief.rows(), relief.columns()});
  std::transform(relief.values().begin(), relief.values().end(), depth_m.mutable_data(),
                 [](const SurfacePatch& patch) { return patch.depth_m; });
  py::dict dict;
  dict["from_m"] = relief.from_m();
  dict["cell_m"] = relief.cell_m();
  dict["depth_m"] = depth_m;
  return dict;
}

}  // namespace

void add_underwater_simulation(py::module_& module) {
  module.def(
      "simulate_auv_survey", &simulate_auv_survey, py::arg("seed") = 0, py::arg("vehicle") = py::dict(), py::arg("lines") = py::dict(),
      "Lines and cross lines of an underwater vehicle over point landmarks: one table a sensor (time first), and the truth. vehicle: "
      "settings of the simulated vehicle and its sensors that differ from their defaults; lines: the same of the lines.");
  module.def(
      "simulate_on_shared_seabed", &simulate_on_shared_seabed, py::arg("seed") = 0, py::arg("vehicle") = py::dict(),
      py::arg("lines") = py::dict(), py::arg("seabed") = py::dict(),
      "The same somewhere on a seabed that missions of one world_seed share. Also start_m, where on it the mission truly starts, origin_m, "
      "where it believes to (north, east), and seabed_landmarks (n, 3).");
  module.def("shared_seabed_fields", &fields_of<SharedSeabedConfig>, "Every key of a shared seabed.");
  py::class_<SideScanMission>(module, "SideScanMission", "A simulated survey with side-scan sonar.")
      .def(py::init(&side_scan_mission), py::arg("config") = py::dict(), py::arg("seed") = 0)
      .def(
          "survey", [](const SideScanMission& mission) { return survey_dict(mission.survey()); },
          "One table a sensor (time first), and the truth, as simulate_auv_survey; without sightings.")
      .def("next_pings", &next_pings, py::arg("most") = 512,
           "The next pings; None at the end. navigation: time, roll, pitch, heading, speed, depth, altitude as the sensors gave them last; "
           "port and starboard: samples, nearest first, one row a ping.");
  py::class_<PhotographedSurvey>(module, "CameraSurvey", "A simulated survey with a down-looking camera.")
      .def(py::init(&camera_survey), py::arg("config") = py::dict(), py::arg("seed") = 0)
      .def(
          "survey", [](const PhotographedSurvey& of) { return survey_dict(of.survey.survey()); },
          "One table a sensor (time first), and the truth, as simulate_auv_survey; without sightings.")
      .def_property_readonly("frame_time_s",
                             [](const PhotographedSurvey& of) {
                               std::vector<double> time_s;
                               for (int frame = 0; frame < of.survey.frames(); ++frame) time_s.push_back(of.survey.frame_time_s(frame));
                               return array_of(time_s);
                             })
      .def_property_readonly("calibration", &camera_of, "Of the frames as they are taken; keys of check_calibration.")
      .def_property_readonly("relief", &relief_of,
                             "from_m (north, east), cell_m and depth_m (rows to the north, columns to the east) of the true seabed.")
      .def("frame", &rendered_frame, py::arg("number"), "(height, width, 3) bytes: red, green, blue.");
  module.def("camera_survey_fields", &fields_of<CameraSurveyConfig>, "Every key of CameraSurvey's configuration.");
  module.def("side_scan_mission_fields", &fields_of<SideScanMissionConfig>, "Every key of SideScanMission's configuration.");
}

}  // namespace ssjs::bindings
