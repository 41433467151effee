// How SlamPipeline looks at its events: checks, motion models, detection.
#include <Eigen/LU>
#include <cmath>
#include <sstream>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/slam_pipeline.hpp"

namespace ssjs {
namespace {

void require_finite(bool finite, const char* what, double time_s) {
  if (finite) return;
  std::ostringstream at;
  at.precision(15);
  at << "not finite at time " << time_s << " s";
  throw InvalidArgument(what, at.str(), "remove the record or mend the log");
}

struct FiniteCheck {
  double time_s;
  void operator()(const AckermanControl& c) const {
    require_finite(std::isfinite(c.speed_m_s) && std::isfinite(c.steering_rad), "odometry", time_s);
  }
  void operator()(const VelocityControl& c) const {
    require_finite(std::isfinite(c.speed_m_s) && std::isfinite(c.turn_rate_rad_s), "odometry", time_s);
  }
  void operator()(const OdometryIncrement& i) const {
    require_finite(i.old_T_new.mean.vector().allFinite() && i.old_T_new.covariance.allFinite(), "odometry increment", time_s);
  }
  void operator()(const Features& scan) const {
    for (const Feature& feature : scan) {
      require_finite(feature.range_bearing.allFinite() && feature.covariance.allFinite(), "observation", time_s);
      if (!(feature.range() > 0.0)) throw InvalidArgument("observation range", feature.range(), "must be positive");
      const Eigen::Matrix2d& R = feature.covariance;
      if (!(R(0, 0) > 0.0 && R(1, 1) > 0.0 && R.determinant() > 0.0)) {
        std::ostringstream at;
        at.precision(15);
        at << "an observation at time " << time_s << " s";
        throw NotPositiveDefinite("observation covariance", at.str());
      }
    }
  }
  void operator()(const LaserScan&) const {}  // beams without a finite range are no return
};

VehicleKind kind_of(const Event& event, VehicleKind otherwise) {
  if (std::holds_alternative<AckermanControl>(event.record)) return VehicleKind::kAckerman;
  if (std::holds_alternative<VelocityControl>(event.record)) return VehicleKind::kUnicycle;
  if (std::holds_alternative<OdometryIncrement>(event.record)) return VehicleKind::kIncrements;
  return otherwise;
}

}  // namespace

void SlamPipeline::check(const Event& event) const {
  if (finished_) throw InvalidArgument("event", event.time_s, "the mission is finished");
  require_finite(std::isfinite(event.time_s), "time", time_s_.value_or(0.0));
  if (time_s_ && event.time_s < *time_s_) {
    std::ostringstream rule;
    rule.precision(15);
    rule << "goes back behind " << *time_s_ << " s: events must come in the order of time";
    throw InvalidArgument("time_s", event.time_s, rule.str());
  }
  if (kind_of(event, config_.vehicle.kind) != config_.vehicle.kind) {
    throw InvalidArgument("odometry", "of another kind", "must match vehicle.kind of the configuration");
  }
  std::visit(FiniteCheck{event.time_s}, event.record);
}

/// Holds the last velocity command until time_s.
void SlamPipeline::advance(double time_s) {
  const double dt_s = time_s_ ? time_s - *time_s_ : 0.0;
  time_s_ = time_s;
  if (!(dt_s > 0.0) || !control_) return;
  const auto step = [&](const Se2& pose) {
    if (const auto* control = std::get_if<AckermanControl>(&control_->record)) {
      return predict_ackerman(pose, *control, dt_s, config_.vehicle.ackerman);
    }
    return predict_unicycle(pose, std::get<VelocityControl>(control_->record), dt_s, config_.vehicle.unicycle);
  };
  builder_.predict(time_s, step(builder_.base_T_vehicle().mean));
  dead_reckoning_ = step(dead_reckoning_).submap_T_vehicle;
}

void SlamPipeline::move(const Event& motion) {
  if (const auto* increment = std::get_if<OdometryIncrement>(&motion.record)) {
    builder_.predict(motion.time_s, predict_increment(builder_.base_T_vehicle().mean, *increment));
    dead_reckoning_ = predict_increment(dead_reckoning_, *increment).submap_T_vehicle;
  } else {
    control_ = motion;
  }
}

Features SlamPipeline::usable(Features scan) const {
  Features kept;
  kept.reserve(scan.size());
  for (Feature& feature : scan) {
    if (feature.range() < config_.sensor.min_range_m || feature.range() > config_.sensor.max_range_m) continue;
    feature.range_bearing.y() = wrap_angle(feature.bearing() + config_.sensor.bearing_offset_rad);
    kept.push_back(feature);
  }
  return kept;
}

Features SlamPipeline::detect(const LaserScan& scan) const {
  Features trunks;
  const Eigen::Vector2d variance(config_.sensor.range_sigma_m * config_.sensor.range_sigma_m,
                                 config_.sensor.bearing_sigma_rad * config_.sensor.bearing_sigma_rad);
  for (const Trunk& trunk : detect_trunks(scan, config_.trees)) {
    trunks.push_back({{trunk.range_m, trunk.bearing_rad}, variance.asDiagonal(), std::nullopt});
  }
  return usable(std::move(trunks));
}

}  // namespace ssjs
