// Side-scan surveys: pings to contacts, simulated or from a log.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "arrays.hpp"
#include "config.hpp"
#include "parts.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/io/sonar_log.hpp"
#include "ssjs/simulation/side_scan_simulator.hpp"
#include "ssjs/survey/side_scan_survey.hpp"
#include "ssjs/survey/survey_record.hpp"

namespace ssjs::bindings {
namespace {

const char* name_of(SonarSide side) { return side == SonarSide::kPort ? "port" : "starboard"; }

SideScanSurveyConfig survey_config(const py::dict& values) {
  const auto config = config_from<SideScanSurveyConfig>(values);
  throw_if_any(config.violations());
  return config;
}

py::dict navigation_dict(const SideScanPing& ping) {
  py::dict entry;
  entry["latitude_deg"] = ping.latitude_deg;
  entry["longitude_deg"] = ping.longitude_deg;
  entry["east_m"] = ping.east_m;
  entry["north_m"] = ping.north_m;
  entry["heading_rad"] = ping.heading_rad;
  entry["roll_rad"] = ping.roll_rad;
  entry["pitch_rad"] = ping.pitch_rad;
  entry["speed_m_s"] = ping.speed_m_s;
  entry["depth_m"] = ping.depth_m;
  entry["altitude_m"] = ping.altitude_m;
  return entry;
}

py::dict contact_dict(const SideScanContact& contact) {
  py::dict entry;
  entry["ping"] = contact.ping;
  entry["index"] = contact.index;
  entry["time_s"] = contact.time_s;
  entry["side"] = name_of(contact.side);
  entry["slant_range_m"] = contact.slant_range_m;
  entry["ground_range_m"] = contact.ground_range_m;
  entry["sample"] = contact.sample;
  const Eigen::Vector3d& p = contact.body_p_contact.position_m;
  entry["body_position_m"] = std::vector<double>(p.data(), p.data() + 3);
  const Eigen::Matrix3d& P = contact.body_p_contact.covariance_m2;
  py::array_t<double> covariance({3, 3});
  for (py::ssize_t r = 0; r < 3; ++r) {
    for (py::ssize_t c = 0; c < 3; ++c) covariance.mutable_at(r, c) = P(r, c);
  }
  entry["body_covariance_m2"] = covariance;
  entry["length_m"] = contact.length_m;
  entry["width_m"] = contact.width_m;
  entry["height_m"] = contact.height_m ? py::cast(*contact.height_m) : py::none();
  entry["shadow_m"] = contact.shadow_m;
  entry["shadow_is_cut"] = contact.shadow_is_cut;
  entry["confidence"] = contact.confidence;
  entry["pieces"] = contact.pieces;
  entry["first_index"] = contact.first_index;
  entry["last_index"] = contact.last_index;
  entry["navigation"] = navigation_dict(contact.navigation);
  return entry;
}

py::list contact_list(const std::vector<SideScanContact>& contacts) {
  py::list all;
  for (const SideScanContact& contact : contacts) all.append(contact_dict(contact));
  return all;
}

/// The next pings of a log, at most so many; fewer at its end.
std::vector<SideScanPing> next_pings(SonarLogReader& log, std::size_t most) {
  std::vector<SideScanPing> pings;
  while (pings.size() < most) {
    std::optional<SonarRecord> record = log.next();
    if (!record) break;
    if (auto* ping = std::get_if<SideScanPing>(&*record)) pings.push_back(std::move(*ping));
  }
  return pings;
}

/// A survey that keeps, where that is asked for, what a report shows of the blocks that are done.
class RecordedSurvey {
 public:
  RecordedSurvey(const SideScanSurveyConfig& config, const std::optional<HaarCascade>& cascade, int pings_around)
      : survey_(config, cascade, pings_around > 0 ? BlockSink([this](const FinishedBlock& finished) { keep(finished); }) : BlockSink{}),
        pings_around_(pings_around) {
    if (pings_around < 0) throw InvalidArgument("pings_around", pings_around, "must not be negative");
  }
  // The survey's sink points to this object.
  RecordedSurvey(const RecordedSurvey&) = delete;
  RecordedSurvey& operator=(const RecordedSurvey&) = delete;

  /// None at the end of the log; then finish() gives what is left.
  py::object feed_log(SonarLogReader& log, std::size_t most_pings) {
    if (most_pings == 0) throw InvalidArgument("most_pings", 0.0, "must be positive");
    std::vector<SideScanContact> contacts;
    bool any = false;
    {
      const py::gil_scoped_release unlocked;
      for (SideScanPing& ping : next_pings(log, most_pings)) {
        any = true;
        for (SideScanContact& contact : survey_.feed(std::move(ping))) contacts.push_back(std::move(contact));
      }
    }
    return any ? py::object(with_rows(contacts)) : py::none();
  }

  py::list finish() {
    std::vector<SideScanContact> contacts;
    {
      const py::gil_scoped_release unlocked;
      contacts = survey_.finish();
    }
    return with_rows(contacts);
  }

  /// One entry a block that was done since the last call.
  py::list take_blocks() {
    py::list all;
    for (const auto& [reach, rows] : blocks_) {
      const auto n = static_cast<py::ssize_t>(reach.size());
      py::array_t<double> time_s(n);
      py::array_t<double> altitude_m(n);
      py::array_t<double> reach_m({n, py::ssize_t{4}});
      for (py::ssize_t i = 0; i < n; ++i) {
        const PingReach& ping = reach[static_cast<std::size_t>(i)];
        time_s.mutable_at(i) = ping.time_s;
        altitude_m.mutable_at(i) = ping.altitude_m;
        for (py::ssize_t side = 0; side < 4; ++side) reach_m.mutable_at(i, side) = ping.reach_m.at(static_cast<std::size_t>(side));
      }
      py::dict entry = rows_dict(rows);
      entry["time_s"] = time_s;
      entry["altitude_m"] = altitude_m;
      entry["reach_m"] = reach_m;
      all.append(entry);
    }
    blocks_.clear();
    return all;
  }

 private:
  void keep(const FinishedBlock& finished) {
    blocks_.emplace_back(own_reach(finished), own_rows(finished));
    for (const SideScanContact& contact : finished.contacts) around_.push_back(rows_around(finished, contact, pings_around_));
  }

  static py::dict rows_dict(const PictureRows& rows) {
    py::dict entry;
    entry["grey"] = picture_array(rows.grey);
    entry["first_index"] = rows.first_index;
    entry["nadir_column"] = rows.nadir_column;
    entry["column_m"] = rows.column_m;
    return entry;
  }

  /// The contacts, each with the picture around it.
  py::list with_rows(const std::vector<SideScanContact>& contacts) {
    py::list all = contact_list(contacts);
    for (std::size_t i = 0; i < around_.size(); ++i) all[i]["picture"] = rows_dict(around_[i]);
    around_.clear();
    return all;
  }

  SideScanSurvey survey_;
  int pings_around_;
  std::vector<std::pair<std::vector<PingReach>, PictureRows>> blocks_;
  std::vector<PictureRows> around_;  ///< in the order of the contacts given out
};

/// Slant and ground range pictures of the pings, and the contacts in them.
py::dict pictures_of(std::vector<SideScanPing> pings, const SideScanSurveyConfig& config, const ToneConfig& tone) {
  SonarImage slant;
  SurveyBlock block;
  int slant_nadir = 0;
  double slant_column_m = 0;
  std::vector<SideScanContact> contacts;
  {
    const py::gil_scoped_release unlocked;
    WaterfallConfig shape;
    shape.channel_pair = config.channel_pair;
    const Waterfall waterfall = slant_waterfall(pings, shape);
    slant_nadir = waterfall.nadir_column;
    slant_column_m = waterfall.column_m;
    slant = in_grey(waterfall, tone);
    SideScanSurvey survey(config);
    for (const SideScanPing& ping : pings) {
      for (SideScanContact& contact : survey.feed(ping)) contacts.push_back(std::move(contact));
    }
    for (SideScanContact& contact : survey.finish()) contacts.push_back(std::move(contact));
    block = survey_block(std::move(pings), config);
  }
  py::list altitudes;
  for (const SideScanPing& ping : block.pings) altitudes.append(ping.altitude_m);
  py::dict answer;
  answer["slant"] = picture_array(slant.intensity);
  answer["slant_nadir_column"] = slant_nadir;
  answer["slant_column_m"] = slant_column_m;
  answer["ground"] = picture_array(block.grey);
  answer["ground_valid"] = picture_array(block.waterfall.valid);
  answer["ground_nadir_column"] = block.waterfall.nadir_column;
  answer["ground_column_m"] = block.waterfall.column_m;
  answer["altitude_m"] = altitudes;
  answer["contacts"] = contact_list(contacts);
  return answer;
}

py::dict simulated_pictures(const py::dict& seabed, const py::dict& track, const py::dict& sonar, const py::dict& survey, int objects,
                            double clearance_m, std::uint64_t seed) {
  const auto survey_values = survey_config(survey);
  const auto track_values = config_from<SurveyTrackConfig>(track);
  const auto sonar_values = config_from<SideScanSimulationConfig>(sonar);
  const auto seabed_values = config_from<SeabedConfig>(seabed);
  std::vector<SideScanPing> pings;
  std::vector<ObjectSighting> sightings;
  std::vector<SeabedObject> placed;
  {
    const py::gil_scoped_release unlocked;
    const double last_east_m = (track_values.lines - 1) * track_values.line_spacing_m;
    placed = scatter_objects(objects, {0.0, -0.85 * sonar_values.range_m},
                             {track_values.line_length_m, last_east_m + 0.85 * sonar_values.range_m}, clearance_m, seed);
    SideScanSimulator simulator(Seabed(seabed_values, placed, seed), sonar_values, seed);
    for (const SonarPose& pose : survey_track(track_values, simulator.seabed(), {0, 0}, seed)) {
      pings.push_back(simulator.ping(pose));
      sightings.insert(sightings.end(), simulator.sightings().begin(), simulator.sightings().end());
    }
  }
  py::dict answer = pictures_of(std::move(pings), survey_values, {});
  py::list truth;
  for (const ObjectSighting& sighting : sightings) {
    const SeabedObject& object = placed[static_cast<std::size_t>(sighting.object)];
    py::dict entry;
    entry["object"] = sighting.object;
    entry["ping"] = sighting.ping;
    entry["side"] = name_of(sighting.side);
    entry["slant_range_m"] = sighting.slant_range_m;
    entry["sample"] = sighting.sample;
    const Eigen::Vector3d& p = sighting.body_p_object;
    entry["body_position_m"] = std::vector<double>(p.data(), p.data() + 3);
    entry["height_m"] = object.height_m;
    entry["length_m"] = object.length_m;
    entry["width_m"] = object.width_m;
    truth.append(entry);
  }
  answer["sightings"] = truth;
  return answer;
}

}  // namespace

void add_survey(py::module_& module) {
  py::class_<RecordedSurvey>(module, "SideScanSurvey", "Contacts of a side-scan log, as its pings come.")
      .def(
          py::init([](const py::dict& config, const std::optional<HaarCascade>& cascade, int pings_around) {
            return std::make_unique<RecordedSurvey>(survey_config(config), cascade, pings_around);
          }),
          py::arg("config") = py::dict(), py::arg("cascade") = py::none(), py::arg("pings_around") = 0,
          "cascade: the model of that detector. pings_around: 0, or so many pings before and after each contact are kept as its `picture`, "
          "and blocks for take_blocks().")
      .def("feed_log", &RecordedSurvey::feed_log, py::arg("log"), py::arg("most_pings") = 512,
           "The contacts that the next pings of the log complete; None at its end.")
      .def("finish", &RecordedSurvey::finish, "The contacts of the pings still held.")
      .def("take_blocks", &RecordedSurvey::take_blocks,
           "What was looked at since the last call, a dictionary a block of pings: time_s, altitude_m (used), reach_m (n, 4) ground ranges "
           "port near, far, starboard near, far, and the ground-range picture with a row a ping.");
  module.def("side_scan_survey_fields", &fields_of<SideScanSurveyConfig>);
  module.def(
      "validate_side_scan_survey", [](const py::dict& values) { return violations(config_from<SideScanSurveyConfig>(values)); },
      py::arg("values"), "Every violation of a flat configuration, as text; unknown keys raise ValueError.");
  module.def("seabed_fields", &fields_of<SeabedConfig>);
  module.def("survey_track_fields", &fields_of<SurveyTrackConfig>);
  module.def("side_scan_simulation_fields", &fields_of<SideScanSimulationConfig>);
  module.def(
      "side_scan_pictures",
      [](SonarLogReader& log, std::size_t most_pings, const py::dict& config) {
        const auto values = survey_config(config);
        std::vector<SideScanPing> pings;
        {
          const py::gil_scoped_release unlocked;
          pings = next_pings(log, most_pings);
        }
        return pictures_of(std::move(pings), values, {});
      },
      py::arg("log"), py::arg("most_pings") = 4096, py::arg("config") = py::dict(),
      "The next pings of a log in slant and in ground range (gain normalised), and their contacts.");
  module.def("simulated_side_scan_pictures", &simulated_pictures, py::arg("seabed") = py::dict(), py::arg("track") = py::dict(),
             py::arg("sonar") = py::dict(), py::arg("survey") = py::dict(), py::arg("objects") = 30, py::arg("clearance_m") = 6.0,
             py::arg("seed") = 1, "A simulated survey in the same form, with the truth of every sighting.");
}

}  // namespace ssjs::bindings
