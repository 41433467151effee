#include "ssjs/simulation/camera_survey.hpp"

#include <cmath>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/simulation/truth_track.hpp"

namespace ssjs {
namespace {

constexpr double kSeenBeside_m = 4.0;  // the seabed is drawn so far outside the lines

CameraSurveyConfig checked(const CameraSurveyConfig& config) {
  throw_if_any(violations(config));
  return config;
}

SeabedTexture seabed_under(const CameraSurveyConfig& config, std::uint64_t seed) {
  const SurveyWorldConfig& lines = config.lines;
  const double margin_m = lines.cross_margin_m + kSeenBeside_m;
  const Eigen::Vector2d far_corner(lines.line_length_m, lines.line_spacing_m * (lines.lines - 1));
  const Eigen::Vector2d margin(margin_m, margin_m);
  return {config.seabed, -margin, far_corner + margin, seed};
}

SimulatedSurvey navigation_over(const SeabedTexture& seabed, const CameraSurveyConfig& config, std::uint64_t seed) {
  SurveyWorldConfig lines = config.lines;
  lines.landmarks = 0;
  const auto depth_m = [&seabed](const Eigen::Vector2d& point_m) { return seabed.ground_depth_m(point_m); };
  return simulate_survey(survey_world(lines, seed), config.vehicle, seed, depth_m);
}

}  // namespace

PinholeCamera SimulatedCameraConfig::pinhole() const {
  return {width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1)};
}

SurveyWorldConfig CameraSurveyConfig::default_lines() {
  SurveyWorldConfig lines;
  lines.lines = 5;
  lines.line_length_m = 20.0;
  lines.line_spacing_m = 5.0;
  lines.cross_lines = 5;
  lines.cross_margin_m = 1.0;
  return lines;
}

AuvSimulationConfig CameraSurveyConfig::default_vehicle() {
  AuvSimulationConfig vehicle;
  vehicle.depth_m = 17.0;
  vehicle.speed_m_s = 0.23;
  vehicle.motion.velocity_walk_m_s_sqrt_s = 0.006;
  vehicle.motion.gyro_sigma_rad_s = 0.0175;  // 1 deg/s: of a small inertial unit
  vehicle.motion.compass_walk_rad_sqrt_s = 0.0035;
  vehicle.velocity_log.sigma_m_s = 0.03;
  vehicle.depth_gain_rad_m = 0.4;
  vehicle.turn_rate_rad_s = 0.25;
  vehicle.lookahead_m = 1.0;
  return vehicle;
}

CameraSurvey::CameraSurvey(const CameraSurveyConfig& config, CameraRays rays, std::uint64_t seed)
    : config_(checked(config)),
      seabed_(seabed_under(config_, seed)),
      renderer_(seabed_, std::move(rays), config_.light, seed),
      survey_(navigation_over(seabed_, config_, seed)),
      frames_(1 + static_cast<int>(survey_.truth.back().time_s * config_.camera.frames_per_s)) {}

double CameraSurvey::frame_time_s(int frame) const { return frame / config_.camera.frames_per_s; }

std::vector<std::uint8_t> CameraSurvey::frame(int number) const {
  if (number < 0 || number >= frames_) throw InvalidArgument("frame", number, "must be one of the survey's frames, from 0");
  const TruthAt at = truth_at(survey_.truth, frame_time_s(number));
  return renderer_.render(at.world_T_vehicle, vehicle_T_camera(config_.camera.mount), static_cast<std::uint64_t>(number));
}

}  // namespace ssjs
