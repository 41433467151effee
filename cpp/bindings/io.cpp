// Sonar logs.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "parts.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/io/sonar_log.hpp"

namespace ssjs::bindings {
namespace py = pybind11;
namespace {

LaybackMode layback_mode(const std::string& name) {
  if (name == "auto") return LaybackMode::kAsFormat;
  if (name == "apply") return LaybackMode::kApply;
  if (name == "ignore") return LaybackMode::kIgnore;
  throw InvalidArgument("layback", name, "must be auto, apply or ignore");
}

/// A block ends after so many records for each ping it may hold: logs may hold hours of attitude between two pings.
constexpr std::size_t kRecordsPerPing = 256;
constexpr std::size_t kMostPings = 1000000;

/// Records sorted out of a log by their kind.
struct Block {
  std::vector<SideScanPing> pings;
  std::vector<PositionRecord> positions;
  std::vector<AttitudeRecord> attitudes;
  std::vector<VelocityRecord> velocities;
  std::vector<DepthRecord> depths;
  std::vector<AltitudeRecord> altitudes;

  void add(SideScanPing&& record) { pings.push_back(std::move(record)); }
  void add(PositionRecord&& record) { positions.push_back(record); }
  void add(AttitudeRecord&& record) { attitudes.push_back(record); }
  void add(VelocityRecord&& record) { velocities.push_back(record); }
  void add(DepthRecord&& record) { depths.push_back(record); }
  void add(AltitudeRecord&& record) { altitudes.push_back(record); }
};

template <class T, class Record, class Field>
py::array_t<T> column(const std::vector<Record>& records, const Field& field) {
  py::array_t<T> values(static_cast<py::ssize_t>(records.size()));
  T* to = values.mutable_data();
  for (const Record& record : records) *to++ = field(record);
  return values;
}

/// One array a field, named as in the header.
template <class Record>
py::dict table(const std::vector<Record>& records, std::initializer_list<std::pair<const char*, double Record::*>> fields) {
  py::dict columns;
  for (const auto& [name, field] : fields) {
    columns[name] = column<double>(records, [member = field](const Record& record) { return record.*member; });
  }
  return columns;
}

py::dict ping_table(const std::vector<SideScanPing>& pings) {
  using P = SideScanPing;
  py::dict columns = table<P>(pings, {{"time_s", &P::time_s},
                                      {"latitude_deg", &P::latitude_deg},
                                      {"longitude_deg", &P::longitude_deg},
                                      {"east_m", &P::east_m},
                                      {"north_m", &P::north_m},
                                      {"position_time_s", &P::position_time_s},
                                      {"heading_rad", &P::heading_rad},
                                      {"roll_rad", &P::roll_rad},
                                      {"pitch_rad", &P::pitch_rad},
                                      {"speed_m_s", &P::speed_m_s},
                                      {"depth_m", &P::depth_m},
                                      {"altitude_m", &P::altitude_m},
                                      {"sound_speed_m_s", &P::sound_speed_m_s}});
  columns["number"] = column<std::int64_t>(pings, [](const P& ping) { return static_cast<std::int64_t>(ping.number); });
  return columns;
}

py::list channels_of(std::vector<SideScanPing>& pings) {
  py::list all;
  for (SideScanPing& ping : pings) {
    py::list channels;
    for (SideScanChannel& channel : ping.channels) {
      py::dict entry;
      entry["side"] = channel.side == SonarSide::kPort ? "port" : "starboard";
      entry["frequency_hz"] = channel.frequency_hz;
      entry["first_sample_s"] = channel.first_sample_s;
      entry["sample_interval_s"] = channel.sample_interval_s;
      auto* kept = new std::vector<float>(std::move(channel.samples));
      const py::capsule owner(kept, [](void* pointer) { delete static_cast<std::vector<float>*>(pointer); });
      entry["samples"] = py::array_t<float>(static_cast<py::ssize_t>(kept->size()), kept->data(), owner);
      channels.append(std::move(entry));
    }
    all.append(std::move(channels));
  }
  return all;
}

py::dict info_dict(const SonarLogInfo& info) {
  py::dict entry;
  entry["format"] = info.format;
  entry["recorder"] = info.recorder;
  entry["sonar"] = info.sonar;
  entry["pings"] = info.pings;
  entry["packet_types"] = info.packet_types;
  entry["repeated_positions"] = info.repeated_positions;
  entry["bytes_skipped"] = info.bytes_skipped;
  py::dict decisions;
  const std::pair<const char*, const Tally*> tallies[] = {{"time_source", &info.time_source},
                                                          {"position_source", &info.position_source},
                                                          {"layback_mode", &info.layback_mode},
                                                          {"altitude_source", &info.altitude_source},
                                                          {"sound_speed_source", &info.sound_speed_source}};
  for (const auto& [name, tally] : tallies) {
    py::dict counts;
    for (const auto& [choice, count] : tally->counts()) counts[py::str(choice)] = count;
    decisions[name] = counts;
  }
  entry["decisions"] = decisions;
  py::list problems;
  for (const LogProblem& problem : info.problems.all()) {
    py::dict line;
    line["what"] = problem.what;
    line["count"] = problem.count;
    line["first_offset"] = problem.first_offset;
    line["data_lost"] = problem.loss == Loss::kData;
    problems.append(std::move(line));
  }
  entry["problems"] = problems;
  return entry;
}

/// The next records up to `most_pings` pings, none at the end of the log.
py::object read_block(SonarLogReader& reader, std::size_t most_pings) {
  if (most_pings == 0 || most_pings > kMostPings)
    throw InvalidArgument("most_pings", static_cast<double>(most_pings), "must be 1 to 1000000");
  Block block;
  bool any = false;
  {
    const py::gil_scoped_release release;
    const std::size_t most_records = most_pings * kRecordsPerPing;
    for (std::size_t records = 0; block.pings.size() < most_pings && records < most_records; ++records) {
      std::optional<SonarRecord> record = reader.next();
      if (!record) break;
      any = true;
      std::visit([&](auto&& value) { block.add(std::move(value)); }, std::move(*record));
    }
  }
  if (!any) return py::none();
  using A = AttitudeRecord;
  using V = VelocityRecord;
  using P = PositionRecord;
  py::dict answer;
  answer["pings"] = ping_table(block.pings);
  answer["channels"] = channels_of(block.pings);
  answer["positions"] = table<P>(block.positions, {{"time_s", &P::time_s},
                                                   {"latitude_deg", &P::latitude_deg},
                                                   {"longitude_deg", &P::longitude_deg},
                                                   {"east_m", &P::east_m},
                                                   {"north_m", &P::north_m}});
  answer["attitudes"] =
      table<A>(block.attitudes,
               {{"time_s", &A::time_s}, {"roll_rad", &A::roll_rad}, {"pitch_rad", &A::pitch_rad}, {"heading_rad", &A::heading_rad}});
  py::dict velocities = table<V>(
      block.velocities,
      {{"time_s", &V::time_s}, {"forward_m_s", &V::forward_m_s}, {"starboard_m_s", &V::starboard_m_s}, {"down_m_s", &V::down_m_s}});
  velocities["bottom_lock"] = column<bool>(block.velocities, [](const V& velocity) { return velocity.bottom_lock; });
  answer["velocities"] = velocities;
  answer["depths"] = table<DepthRecord>(block.depths, {{"time_s", &DepthRecord::time_s}, {"depth_m", &DepthRecord::depth_m}});
  answer["altitudes"] =
      table<AltitudeRecord>(block.altitudes, {{"time_s", &AltitudeRecord::time_s}, {"altitude_m", &AltitudeRecord::altitude_m}});
  return answer;
}

}  // namespace

void add_io(py::module_& module) {
  py::class_<SonarLogReader>(module, "SonarLog", "A side-scan log, XTF or JSF, read block by block.")
      .def(py::init([](const std::string& path, const std::string& layback) {
             SonarLogConfig config;
             config.layback = layback_mode(layback);
             return open_sonar_log(path, config);
           }),
           py::arg("path"), py::arg("layback") = "auto")
      .def("read", &read_block, py::arg("most_pings"),
           "The next records, up to most_pings pings, as columns; None at the end. Samples: nearest first, linear.")
      .def(
          "info", [](const SonarLogReader& reader) { return info_dict(reader.info()); }, "What was found and decided so far.");
}

}  // namespace ssjs::bindings
