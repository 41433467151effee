#include "ssjs/survey/side_scan_geometry.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/se3.hpp"

namespace ssjs {
namespace {

/// Standard deviation of a place spread evenly over one.
const double kUniformSigma = 1.0 / std::sqrt(12.0);

Eigen::Vector3d sonar_in_body(SonarSide side, const SideScanGeometryConfig& config) {
  return {config.sonar_x_m, starboard_sign(side) * config.sonar_y_m, config.sonar_z_m};
}

double lean(const SideScanPing& ping) { return std::isfinite(ping.pitch_rad) ? std::cos(ping.pitch_rad) : 1.0; }

void check(const SideScanEcho& echo) {
  if (!(echo.altitude_m > 0) || !std::isfinite(echo.altitude_m))
    throw InvalidArgument("altitude_m", echo.altitude_m, "must be finite and positive; bottom tracking finds it where the log has none");
  if (!(echo.slant_range_m > 0) || !std::isfinite(echo.slant_range_m))
    throw InvalidArgument("slant_range_m", echo.slant_range_m, "must be finite and positive");
  if (!std::isfinite(echo.roll_rad) || !std::isfinite(echo.pitch_rad))
    throw InvalidArgument("roll_rad, pitch_rad", std::isfinite(echo.roll_rad) ? echo.pitch_rad : echo.roll_rad, "must be finite");
}

std::optional<SideScanPoint> with_covariance(const std::optional<SideScanSolution>& solution, const SideScanEcho& echo,
                                             const SideScanGeometryConfig& config) {
  if (!solution) return std::nullopt;
  Eigen::Matrix<double, kSideScanInputs, 1> variance;
  const auto square = [](double value) { return value * value; };
  variance(kSlantRange) = square(config.range_sigma_m) + square(kUniformSigma * config.sample_m);
  variance(kAltitude) = square(config.altitude_sigma_m);
  variance(kRoll) = square(config.roll_sigma_rad);
  variance(kPitch) = square(config.pitch_sigma_rad);
  variance(kSlopeForward) = variance(kSlopeStarboard) = square(config.slope_sigma);
  // (SS-8) a beam is as wide as a Gaussian of so many standard deviations at half its height
  const double beam_sigma_m = config.beam_width_rad * echo.slant_range_m / (2.0 * std::sqrt(2.0 * std::log(2.0)));
  variance(kAlongTrack) = square(beam_sigma_m) + square(config.time_sigma_s * config.speed_m_s);
  return SideScanPoint{solution->position_m, solution->jacobian * variance.asDiagonal() * solution->jacobian.transpose()};  // (SS-9)
}

}  // namespace

// (SS-2)
double slant_range_m(const SideScanPing& ping, const SideScanChannel& channel, double sample) {
  if (!(ping.sound_speed_m_s > 0)) throw InvalidArgument("sound_speed_m_s", ping.sound_speed_m_s, "must be known and positive");
  return 0.5 * ping.sound_speed_m_s * (channel.first_sample_s + sample * channel.sample_interval_s);
}

double sample_at_slant_range(const SideScanPing& ping, const SideScanChannel& channel, double slant_range_m) {
  if (!(ping.sound_speed_m_s > 0)) throw InvalidArgument("sound_speed_m_s", ping.sound_speed_m_s, "must be known and positive");
  if (!(channel.sample_interval_s > 0)) throw InvalidArgument("sample_interval_s", channel.sample_interval_s, "must be positive");
  return (2.0 * slant_range_m / ping.sound_speed_m_s - channel.first_sample_s) / channel.sample_interval_s;
}

// (SS-13)
double first_return_m(const SideScanPing& ping) { return ping.altitude_m / lean(ping); }
double altitude_of_first_return_m(const SideScanPing& ping, double first_return_m) { return first_return_m * lean(ping); }

std::optional<SideScanSolution> solve_in_body(const SideScanEcho& echo, const SideScanGeometryConfig& config) {
  check(echo);
  const Eigen::Vector3d tilt(echo.roll_rad, echo.pitch_rad, 0.0);
  const Eigen::Vector3d upright(-config.slope_forward, -config.slope_starboard, 1.0);
  const Eigen::Vector3d n = rotation_from_rpy(tilt).transpose() * upright;  // (SS-3) the plane's normal in the body frame
  const double sign = starboard_sign(echo.side);
  const double reach = std::hypot(n.y(), n.z());
  const double r = echo.slant_range_m;
  const double ratio = echo.altitude_m / (r * reach);
  if (!(ratio < 1.0)) return std::nullopt;                                 // still in the water
  const double beta = std::atan2(n.z(), sign * n.y()) - std::acos(ratio);  // (SS-4) below the body's own horizon
  const double c = std::cos(beta);
  const double s = std::sin(beta);

  SideScanSolution solution;
  solution.position_m = sonar_in_body(echo.side, config) + Eigen::Vector3d(0.0, sign * r * c, r * s);

  // (SS-6) beta is the root of f = r (sign n_y cos + n_z sin) - altitude
  const Eigen::Vector3d ray(0.0, sign * c, s);
  const double f_beta = r * (-sign * n.y() * s + n.z() * c);
  Eigen::Matrix<double, 1, kSideScanInputs> f;
  const Eigen::Matrix3d turning = inverse_rotate_jacobian(tilt, upright);  // of n
  f(kSlantRange) = echo.altitude_m / r;
  f(kAltitude) = -1.0;
  f(kRoll) = r * ray.dot(turning.col(0));
  f(kPitch) = r * ray.dot(turning.col(1));
  f(kSlopeForward) = -r * ray.dot(rotation_from_rpy(tilt).row(0));
  f(kSlopeStarboard) = -r * ray.dot(rotation_from_rpy(tilt).row(1));
  f(kAlongTrack) = 0.0;
  solution.jacobian = Eigen::Vector3d(0.0, -sign * r * s, r * c) * (-f / f_beta);  // (SS-7)
  solution.jacobian.col(kSlantRange) += ray;
  solution.jacobian(0, kAlongTrack) += 1.0;
  return solution;
}

std::optional<SideScanSolution> solve_levelled(const SideScanEcho& echo, const SideScanGeometryConfig& config) {
  const std::optional<SideScanSolution> body = solve_in_body(echo, config);
  if (!body) return std::nullopt;
  const Eigen::Vector3d tilt(echo.roll_rad, echo.pitch_rad, 0.0);
  SideScanSolution levelled{rotation_from_rpy(tilt) * body->position_m, rotation_from_rpy(tilt) * body->jacobian};
  levelled.jacobian.col(kRoll) += rotate_jacobian(tilt, body->position_m).col(0);
  levelled.jacobian.col(kPitch) += rotate_jacobian(tilt, body->position_m).col(1);
  return levelled;
}

std::optional<double> ground_range_on_slope_m(const SideScanEcho& echo, const SideScanGeometryConfig& config) {
  const std::optional<SideScanSolution> body = solve_in_body(echo, config);
  if (!body) return std::nullopt;
  const Eigen::Vector3d from_sonar = body->position_m - sonar_in_body(echo.side, config);
  const Eigen::Vector3d levelled = rotation_from_rpy({echo.roll_rad, echo.pitch_rad, 0.0}) * from_sonar;
  return starboard_sign(echo.side) * levelled.y();  // (SS-5)
}

std::optional<SideScanPoint> body_point(const SideScanEcho& echo, const SideScanGeometryConfig& config) {
  return with_covariance(solve_in_body(echo, config), echo, config);
}

std::optional<SideScanPoint> levelled_point(const SideScanEcho& echo, const SideScanGeometryConfig& config) {
  return with_covariance(solve_levelled(echo, config), echo, config);
}

}  // namespace ssjs
