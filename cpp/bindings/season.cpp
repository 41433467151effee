// Seasons: the maps of many missions joined to one.
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "columns.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "run_parts.hpp"
#include "ssjs/joining/season.hpp"

namespace ssjs::bindings {
namespace {

using Array = py::EigenDRef<const Eigen::MatrixXd>;

/// Missions from Python, one after the other.
class SeasonMaps {
 public:
  void add(const Eigen::Vector3d& pose, const Eigen::Matrix3d& pose_covariance, const Array& position, const Array& covariance) {
    if (position.cols() != 3) throw InvalidArgument("position", std::to_string(position.cols()) + " columns", "n x 3: x, y, depth");
    MissionMap mission;
    mission.world_T_mission = {Se2::from_vector(pose), pose_covariance};
    mission.mean.resize(3 * position.rows());
    for (Eigen::Index i = 0; i < position.rows(); ++i) mission.mean.segment<3>(3 * i) = position.row(i).transpose();
    mission.covariance = covariance;
    missions.push_back(std::move(mission));
  }
  std::vector<MissionMap> missions;
};

py::dict to_python(const SeasonEstimate& season) {
  const auto missions = static_cast<Eigen::Index>(season.world_T_mission.size());
  const auto contacts = static_cast<Eigen::Index>(season.contacts.size());
  RowMatrix frames(missions, 3), frame_covariance(missions, 6), position(contacts, 3), covariance(contacts, 6);
  for (Eigen::Index i = 0; i < missions; ++i) {
    const GaussianSe2& frame = season.world_T_mission[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d& P = frame.covariance;
    frames.row(i) = frame.mean.vector();
    frame_covariance.row(i) << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
  }
  std::vector<std::int64_t> contact_of, mission_of, landmark_of;
  for (Eigen::Index i = 0; i < contacts; ++i) {
    const SeasonContact& contact = season.contacts[static_cast<std::size_t>(i)];
    const Eigen::Matrix3d& P = contact.covariance;
    position.row(i) = contact.position;
    covariance.row(i) << P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2);
    for (const MissionLandmark& sighting : contact.sightings) {
      contact_of.push_back(i);
      mission_of.push_back(static_cast<std::int64_t>(sighting.mission));
      landmark_of.push_back(static_cast<std::int64_t>(sighting.landmark));
    }
  }
  py::dict dict;
  dict["frames"] = frames;
  dict["frame_covariance"] = frame_covariance;
  dict["sites"] = season.sites;
  dict["position"] = position;
  dict["covariance"] = covariance;
  dict["sighting_contact"] = array_of(contact_of);
  dict["sighting_mission"] = array_of(mission_of);
  dict["sighting_landmark"] = array_of(landmark_of);
  dict["budget_exhausted"] = season.budget_exhausted;
  return dict;
}

}  // namespace

void add_season(py::module_& module) {
  module.def("season_config_fields", &fields_of<SeasonConfig>, "Every key of merge_missions' configuration.");
  py::class_<SeasonMaps>(module, "SeasonMaps", "The maps of missions, to be merged.")
      .def(py::init<>())
      .def("add", &SeasonMaps::add, py::arg("pose"), py::arg("pose_covariance"), py::arg("position"), py::arg("covariance"),
           "pose: x, y, heading of the mission's frame in the world by its origin alone; position: n x 3 x, y, depth in the mission's "
           "frame; "
           "covariance: 3n x 3n, of all of them.")
      .def("__len__", [](const SeasonMaps& maps) { return maps.missions.size(); });
  module.def(
      "merge_missions",
      [](const SeasonMaps& maps, const py::dict& values, const std::optional<std::function<bool(double)>>& progress) {
        const auto config = config_from<SeasonConfig>(values);
        const ProgressSink sink = progress_sink(progress);
        SeasonEstimate season;
        {
          const py::gil_scoped_release released;
          season = join_missions(maps.missions, config, sink);
        }
        return to_python(season);
      },
      py::arg("maps"), py::arg("config") = py::dict(), py::arg("progress") = py::none(),
      "The contacts of all missions, those that several missions saw once, and where the frame of every mission is by that. Sightings are "
      "rows of (contact, mission, landmark).");
}

}  // namespace ssjs::bindings
