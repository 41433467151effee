#include "mission_file.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <stdexcept>

#include "ssjs/base/random.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs::benchmarks {
namespace {

/// One tick; its sightings follow.
struct Record {
  double time_s;
  double gyro_rad_s[3], roll_pitch_rad[2], compass_rad, depth_m, altitude_m, velocity_m_s[3];
  bool has_attitude, has_compass, has_depth, has_altitude, has_velocity, bottom_lock;
  std::int32_t sightings;
};

struct SightingRecord {
  double vehicle_p_point[3];
  double covariance[9];
  std::int64_t landmark_id;
};

template <class Vector>
void put(const Vector& from, double* to) {
  std::copy_n(from.data(), from.size(), to);
}

void write(std::FILE* file, const NavigationTick& tick) {
  Record record{};
  record.time_s = tick.time_s;
  if (tick.gyro_rad_s) put(*tick.gyro_rad_s, record.gyro_rad_s);
  record.has_attitude = tick.roll_pitch_rad.has_value();
  if (tick.roll_pitch_rad) put(*tick.roll_pitch_rad, record.roll_pitch_rad);
  record.has_compass = tick.compass_rad.has_value();
  record.compass_rad = tick.compass_rad.value_or(0.0);
  record.has_depth = tick.depth_m.has_value();
  record.depth_m = tick.depth_m.value_or(0.0);
  record.has_altitude = tick.altitude_m.has_value();
  record.altitude_m = tick.altitude_m.value_or(0.0);
  record.has_velocity = tick.velocity.has_value();
  if (tick.velocity) {
    put(tick.velocity->velocity_m_s, record.velocity_m_s);
    record.bottom_lock = tick.velocity->bottom_lock;
  }
  record.sightings = static_cast<std::int32_t>(tick.sightings.size());
  bool written = std::fwrite(&record, sizeof record, 1, file) == 1;
  for (const SideScanSighting& sighting : tick.sightings) {
    SightingRecord point{};
    put(sighting.vehicle_p_point, point.vehicle_p_point);
    put(*sighting.covariance, point.covariance);
    point.landmark_id = sighting.landmark_id.value_or(-1);
    written = written && std::fwrite(&point, sizeof point, 1, file) == 1;
  }
  if (!written) throw std::runtime_error("mission file: cannot be written");
}

void simulate(const std::string& path, const DayConfig& config) {
  AuvSimulationConfig simulation;
  simulation.duration_s = 3600.0 * config.hours;
  SurveyWorldConfig survey;
  survey.line_length_m = config.line_length_m;
  survey.line_spacing_m = config.line_spacing_m;
  const double way_m = simulation.speed_m_s * *simulation.duration_s;
  const double per_block_m = config.lines_per_cross * (config.line_length_m + config.line_spacing_m);
  SurveyWorld world;
  // Block after block: lines to and fro, then one across them all the way back to where the block began, and on to the next block.
  double east_m = 0.0;
  for (double done_m = 0.0; done_m < way_m + per_block_m; done_m += per_block_m) {
    for (int line = 0; line < config.lines_per_cross; ++line, east_m += config.line_spacing_m) {
      const bool north = line % 2 == 0;
      world.waypoints.emplace_back(north ? 0.0 : config.line_length_m, east_m);
      world.waypoints.emplace_back(north ? config.line_length_m : 0.0, east_m);
    }
    const double begin_m = east_m - config.lines_per_cross * config.line_spacing_m;
    world.waypoints.emplace_back(0.3 * config.line_length_m, east_m);
    world.waypoints.emplace_back(0.3 * config.line_length_m, begin_m - 2.0 * config.line_spacing_m);
    world.waypoints.emplace_back(0.7 * config.line_length_m, begin_m - 2.0 * config.line_spacing_m);
    world.waypoints.emplace_back(0.7 * config.line_length_m, east_m);
    done_m += 2.0 * (config.lines_per_cross + 2) * config.line_spacing_m;
  }
  constexpr double kMargin_m = 40.0;
  Rng places = Rng(config.seed).stream("landmarks");
  const double area_km2 = 1e-6 * (config.line_length_m + 2.0 * kMargin_m) * (east_m + 2.0 * kMargin_m);
  const auto count = static_cast<Eigen::Index>(std::lround(config.landmarks_per_km2 * area_km2));
  world.landmarks_m.resize(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double x = places.uniform(-kMargin_m, config.line_length_m + kMargin_m);
    const double y = places.uniform(-kMargin_m, east_m + kMargin_m);
    world.landmarks_m.col(i) << x, y, 16.0 + places.normal(0.2);
    world.ids.push_back(i);
  }
  const SimulatedSurvey mission = simulate_survey(world, simulation, config.seed);
  const std::string unfinished = path + ".part";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(unfinished.c_str(), "wb"), &std::fclose);
  if (!file) throw std::runtime_error(path + ": cannot be written");
  for (const NavigationTick& tick : mission.ticks) write(file.get(), tick);
  if (std::fflush(file.get()) != 0 || std::rename(unfinished.c_str(), path.c_str()) != 0) {
    throw std::runtime_error(path + ": cannot be written");
  }
}

}  // namespace

void write_mission(const std::string& path, const DayConfig& config) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process to simulate in");
  if (child == 0) {
    try {
      simulate(path, config);
    } catch (const std::exception& problem) {
      std::fprintf(stderr, "%s\n", problem.what());
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) throw std::runtime_error("the mission could not be simulated");
}

MissionFile::MissionFile(const std::string& path) : file_(std::fopen(path.c_str(), "rb")) {
  if (!file_) throw std::runtime_error(path + ": cannot be read");
}

std::optional<NavigationTick> MissionFile::next() {
  Record record;
  if (std::fread(&record, sizeof record, 1, file_.get()) != 1) return std::nullopt;
  NavigationTick tick = tick_at(record.time_s);
  tick.gyro_rad_s = Eigen::Map<const Eigen::Vector3d>(record.gyro_rad_s);
  if (record.has_attitude) tick.roll_pitch_rad = Eigen::Map<const Eigen::Vector2d>(record.roll_pitch_rad);
  if (record.has_compass) tick.compass_rad = record.compass_rad;
  if (record.has_depth) tick.depth_m = record.depth_m;
  if (record.has_altitude) tick.altitude_m = record.altitude_m;
  if (record.has_velocity) {
    tick.velocity = VelocitySample{Eigen::Map<const Eigen::Vector3d>(record.velocity_m_s), record.bottom_lock, std::nullopt};
  }
  for (std::int32_t i = 0; i < record.sightings; ++i) {
    SightingRecord point;
    if (std::fread(&point, sizeof point, 1, file_.get()) != 1) throw std::runtime_error("mission file: cut off");
    SideScanSighting sighting;
    sighting.vehicle_p_point = Eigen::Map<const Eigen::Vector3d>(point.vehicle_p_point);
    sighting.covariance = Eigen::Map<const Eigen::Matrix3d>(point.covariance);
    sighting.landmark_id = point.landmark_id;
    tick.sightings.push_back(sighting);
  }
  return tick;
}

}  // namespace ssjs::benchmarks
