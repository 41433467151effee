#include "ssjs/sensors/unicycle.hpp"

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// S = sin(t)/t and C = (1 - cos(t))/t with their derivatives; by series where the quotients lose digits.
struct ArcTerms {
  double S, C, S_prime, C_prime;
};

ArcTerms arc_terms(double t) {
  constexpr double kSeriesBelowRadians = 1e-2;  // the first neglected terms are below 1e-14 there
  if (std::abs(t) < kSeriesBelowRadians) {
    const double t2 = t * t;
    return {1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0)), 0.5 * t * (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0))),
            -t / 3.0 * (1.0 - t2 / 10.0 * (1.0 - t2 / 28.0)), 0.5 - t2 / 8.0 * (1.0 - t2 / 18.0 * (1.0 - t2 / 40.0))};
  }
  const double S = std::sin(t) / t;
  const double C = (1.0 - std::cos(t)) / t;
  return {S, C, (std::cos(t) - S) / t, S - C / t};
}

double variance(double sigma, double fraction, double command) { return sigma * sigma + fraction * fraction * command * command; }

}  // namespace

MotionPrediction predict_unicycle(const Se2& submap_T_vehicle, const VelocityControl& control, double dt_s, const UnicycleConfig& config) {
  if (!(dt_s >= 0.0) || !std::isfinite(dt_s)) throw InvalidArgument("predict_unicycle dt_s", dt_s, "must be zero or positive, and finite");
  if (!std::isfinite(control.speed_m_s)) throw InvalidArgument("VelocityControl.speed_m_s", control.speed_m_s, "must be finite");
  if (!std::isfinite(control.turn_rate_rad_s)) {
    throw InvalidArgument("VelocityControl.turn_rate_rad_s", control.turn_rate_rad_s, "must be finite");
  }
  const double turn = dt_s * control.turn_rate_rad_s;
  const double distance = dt_s * control.speed_m_s;
  const ArcTerms arc = arc_terms(turn);
  const Se2 old_T_new{distance * arc.S, distance * arc.C, wrap_angle(turn)};

  MotionPrediction prediction;
  prediction.submap_T_vehicle = submap_T_vehicle * old_T_new;         // (M-5)
  prediction.F = compose_jacobian_left(submap_T_vehicle, old_T_new);  // (M-6)
  prediction.Q.setZero();
  if (control.speed_m_s == 0.0 && control.turn_rate_rad_s == 0.0) return prediction;

  // (M-7) rates of the increment with respect to speed, turn rate and side slip; dt^2 * sigma^2 * (noise_step / dt)
  const Eigen::Vector3d g_speed(arc.S, arc.C, 0.0);
  const Eigen::Vector3d g_turn(distance * arc.S_prime, distance * arc.C_prime, 1.0);
  const Eigen::Vector3d g_lateral(-arc.C, arc.S, 0.0);
  const double scale = dt_s * config.noise_step_s;
  const Eigen::Matrix3d old_Q_new =
      scale *
      (variance(config.speed_sigma_m_s, config.speed_sigma_fraction, control.speed_m_s) * g_speed * g_speed.transpose() +
       variance(config.turn_rate_sigma_rad_s, config.turn_rate_sigma_fraction, control.turn_rate_rad_s) * g_turn * g_turn.transpose() +
       variance(config.lateral_sigma_m_s, 0.0, 0.0) * g_lateral * g_lateral.transpose());
  const Eigen::Matrix3d J2 = compose_jacobian_right(submap_T_vehicle);
  prediction.Q = J2 * old_Q_new * J2.transpose();
  return prediction;
}

}  // namespace ssjs
