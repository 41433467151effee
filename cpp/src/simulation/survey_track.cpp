#include "ssjs/simulation/survey_track.hpp"

#include <array>
#include <cmath>

#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// A sum of three sines with incommensurable periods.
class Swing {
 public:
  Swing(Rng& rng, double sigma) : amplitude_(sigma * std::sqrt(2.0 / 3.0)) {
    for (double& phase : phases_) phase = rng.uniform(-kPi, kPi);
  }
  [[nodiscard]] double at(double time_s) const {
    constexpr std::array<double, 3> kPeriods_s = {4.1, 7.3, 12.7};
    double sum = 0;
    for (std::size_t i = 0; i < phases_.size(); ++i) sum += amplitude_ * std::sin(2.0 * kPi * time_s / kPeriods_s[i] + phases_[i]);
    return sum;
  }

 private:
  double amplitude_;
  std::array<double, 3> phases_{};
};

struct PathPoint {
  Eigen::Vector2d position_m;
  double course_rad;
};

/// So far along the lawn mower.
PathPoint lawn_mower(const SurveyTrackConfig& config, const Eigen::Vector2d& start_m, double travelled_m) {
  const double turn_m = 0.5 * kPi * config.line_spacing_m;
  const double leg_m = config.line_length_m + turn_m;
  const int line = std::min(static_cast<int>(travelled_m / leg_m), config.lines - 1);
  const double on_leg_m = travelled_m - line * leg_m;
  const bool northward = line % 2 == 0;
  const double east = start_m.y() + line * config.line_spacing_m;
  const double direction = northward ? 1.0 : -1.0;
  const double from = northward ? start_m.x() : start_m.x() + config.line_length_m;
  if (on_leg_m <= config.line_length_m) return {{from + direction * on_leg_m, east}, northward ? 0.0 : -kPi};
  const double radius = 0.5 * config.line_spacing_m;
  const double angle = (on_leg_m - config.line_length_m) / radius;  // 0 .. pi, always turning towards the next line
  const Eigen::Vector2d position(from + direction * (config.line_length_m + radius * std::sin(angle)),
                                 east + radius * (1.0 - std::cos(angle)));
  return {position, wrap_angle(northward ? angle : kPi - angle)};
}

}  // namespace

std::vector<SonarPose> survey_track(const SurveyTrackConfig& config, const Seabed& seabed, const Eigen::Vector2d& start_m,
                                    std::uint64_t seed) {
  throw_if_any(violations(config));
  Rng rng = Rng(seed).stream("attitude");
  const Swing roll(rng, config.roll_sigma_rad);
  const Swing pitch(rng, config.pitch_sigma_rad);
  const Swing yaw(rng, config.yaw_sigma_rad);
  const double length_m = config.lines * config.line_length_m + (config.lines - 1) * 0.5 * kPi * config.line_spacing_m;
  const double plane_depth_m = seabed.plane_depth_m();
  std::vector<SonarPose> poses;
  const auto count = static_cast<std::size_t>(length_m / config.speed_m_s * config.pings_per_s) + 1;
  poses.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double time_s = static_cast<double>(i) / config.pings_per_s;
    const PathPoint point = lawn_mower(config, start_m, config.speed_m_s * time_s);
    const double depth_m = plane_depth_m + seabed.slope().dot(point.position_m) - config.altitude_m;
    poses.push_back({time_s,
                     {{point.position_m.x(), point.position_m.y(), depth_m},
                      {roll.at(time_s), pitch.at(time_s), wrap_angle(point.course_rad + yaw.at(time_s))}},
                     config.speed_m_s});
  }
  return poses;
}

}  // namespace ssjs
