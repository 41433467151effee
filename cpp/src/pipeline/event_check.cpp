#include "ssjs/pipeline/event_check.hpp"

#include <Eigen/LU>
#include <cmath>
#include <sstream>

#include "ssjs/base/error.hpp"

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

void check_event(const Event& event, std::optional<double> last_time_s, VehicleKind kind) {
  require_finite(std::isfinite(event.time_s), "time", last_time_s.value_or(0.0));
  if (last_time_s && event.time_s < *last_time_s) {
    std::ostringstream rule;
    rule.precision(15);
    rule << "goes back behind " << *last_time_s << " s: events must come in the order of time";
    throw InvalidArgument("time_s", event.time_s, rule.str());
  }
  if (kind_of(event, kind) != kind) throw InvalidArgument("odometry", "of another kind", "must match vehicle.kind of the configuration");
  std::visit(FiniteCheck{event.time_s}, event.record);
}

}  // namespace ssjs
