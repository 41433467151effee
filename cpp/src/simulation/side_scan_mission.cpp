#include "ssjs/simulation/side_scan_mission.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/simulation/truth_track.hpp"

namespace ssjs {
namespace {

Seabed seabed_with_objects(const SideScanMissionConfig& config, std::uint64_t seed) {
  throw_if_any(violations(config));
  const SurveyWorldConfig& lines = config.lines;
  const double margin_m = lines.landmark_margin_m;
  const Eigen::Vector2d far_corner(lines.line_length_m, lines.line_spacing_m * (lines.lines - 1));
  const Eigen::Vector2d margin(margin_m, margin_m);
  return {config.seabed, scatter_objects(config.objects, -margin, far_corner + margin, config.clearance_m, seed), seed};
}

SimulatedSurvey navigation_over(const Seabed& seabed, const SideScanMissionConfig& config, std::uint64_t seed) {
  SurveyWorldConfig lines = config.lines;
  lines.landmarks = 0;
  const auto depth_m = [&seabed](const Eigen::Vector2d& point_m) { return seabed.depth_m(point_m); };
  SimulatedSurvey survey = simulate_survey(survey_world(lines, seed), config.vehicle, seed, depth_m);
  survey.world.landmarks_m.resize(3, static_cast<Eigen::Index>(seabed.objects().size()));
  for (std::size_t i = 0; i < seabed.objects().size(); ++i) {
    const SeabedObject& object = seabed.objects()[i];
    survey.world.landmarks_m.col(static_cast<Eigen::Index>(i)) << object.position_m, seabed.foot_depth_m(i);
    survey.world.ids.push_back(object.id);
  }
  return survey;
}

double known_heading(double compass_rad) { return compass_rad < 0 ? compass_rad + 2.0 * kPi : compass_rad; }

}  // namespace

SeabedConfig SideScanMissionConfig::default_seabed() {
  SeabedConfig config;
  config.depth_m = SurveyWorldConfig{}.seabed_depth_m;
  return config;
}

SideScanSimulationConfig SideScanMissionConfig::default_sonar() {
  SideScanSimulationConfig config;
  config.samples = 400;
  return config;
}

SideScanMission::SideScanMission(const SideScanMissionConfig& config, std::uint64_t seed)
    : simulator_(seabed_with_objects(config, seed), config.sonar, seed),
      survey_(navigation_over(simulator_.seabed(), config, seed)),
      ping_interval_s_(config.ping_interval_s),
      max_altitude_m_(config.max_altitude_m) {}

std::optional<SideScanPing> SideScanMission::next_ping() {
  double time_s = 0.0;
  do {
    time_s = static_cast<double>(triggers_++) * ping_interval_s_;
    if (time_s > survey_.truth.back().time_s) return std::nullopt;
    update_navigation(time_s);
    if (sonar_is_off()) simulator_.pause();
  } while (sonar_is_off());
  SideScanPing ping = simulator_.ping(pose_at(time_s));
  std::vector<SideScanChannel> channels = std::move(ping.channels);
  const std::uint32_t number = ping.number;
  const double sound_speed_m_s = ping.sound_speed_m_s;
  ping = measured_;
  ping.time_s = time_s;
  ping.number = number;
  ping.sound_speed_m_s = sound_speed_m_s;
  ping.channels = std::move(channels);
  return ping;
}

bool SideScanMission::sonar_is_off() const { return max_altitude_m_ && measured_.altitude_m > *max_altitude_m_; }

SonarPose SideScanMission::pose_at(double time_s) const {
  const TruthAt at = truth_at(survey_.truth, time_s);
  return {time_s, at.world_T_vehicle, at.step.velocity_m_s.norm()};
}

void SideScanMission::update_navigation(double time_s) {
  for (; next_tick_ < survey_.ticks.size() && survey_.ticks[next_tick_].time_s <= time_s; ++next_tick_) {
    const NavigationTick& tick = survey_.ticks[next_tick_];
    if (tick.roll_pitch_rad) {
      measured_.roll_rad = tick.roll_pitch_rad->x();
      measured_.pitch_rad = tick.roll_pitch_rad->y();
    }
    if (tick.compass_rad) measured_.heading_rad = known_heading(*tick.compass_rad);
    if (tick.depth_m) measured_.depth_m = *tick.depth_m;
    if (tick.altitude_m) measured_.altitude_m = *tick.altitude_m;
    if (tick.velocity && tick.velocity->bottom_lock) measured_.speed_m_s = tick.velocity->velocity_m_s.head<2>().norm();
  }
}

}  // namespace ssjs
