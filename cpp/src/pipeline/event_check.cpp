#include "ssjs/pipeline/event_check.hpp"

#include <Eigen/Eigenvalues>
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

[[noreturn]] void refuse_covariance(const char* matrix, const char* record, double time_s) {
  std::ostringstream at;
  at.precision(15);
  at << record << " at time " << time_s << " s";
  throw NotPositiveDefinite(matrix, at.str());
}

struct RecordCheck {
  double time_s;
  void operator()(const AckermanControl& c) const {
    require_finite(std::isfinite(c.speed_m_s) && std::isfinite(c.steering_rad), "odometry", time_s);
  }
  void operator()(const VelocityControl& c) const {
    require_finite(std::isfinite(c.speed_m_s) && std::isfinite(c.turn_rate_rad_s), "odometry", time_s);
  }
  void operator()(const OdometryIncrement& i) const {
    const Eigen::Matrix3d& P = i.old_T_new.covariance;
    require_finite(i.old_T_new.mean.vector().allFinite() && P.allFinite(), "odometry increment", time_s);
    const Eigen::Vector3d variances = P.selfadjointView<Eigen::Lower>().eigenvalues();
    if (variances.minCoeff() < -1e-9 * variances.maxCoeff()) refuse_covariance("odometry covariance", "an increment", time_s);
  }
  void operator()(const Features& scan) const {
    for (const Feature& feature : scan) {
      require_finite(feature.range_bearing.allFinite() && feature.covariance.allFinite(), "observation", time_s);
      if (!(feature.range() > 0.0)) throw InvalidArgument("observation range", feature.range(), "must be positive");
      const Eigen::Matrix2d& R = feature.covariance;
      if (!(R(0, 0) > 0.0 && R(1, 1) > 0.0 && R.determinant() > 0.0)) refuse_covariance("observation covariance", "an observation", time_s);
    }
  }
  void operator()(const SonarHits& image) const {
    for (const Eigen::Vector2d& hit : image.range_bearing) {
      require_finite(hit.allFinite(), "sonar hit", time_s);
      if (!(hit.x() > 0.0)) throw InvalidArgument("sonar hit range", hit.x(), "must be positive");
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

void check_event(const Event& event, std::optional<double> last_time_s, const VehicleConfig& vehicle) {
  require_finite(std::isfinite(event.time_s), "time", last_time_s.value_or(0.0));
  if (last_time_s && event.time_s < *last_time_s) {
    std::ostringstream rule;
    rule.precision(15);
    rule << "goes back behind " << *last_time_s << " s: events must come in the order of time";
    throw InvalidArgument("time_s", event.time_s, rule.str());
  }
  if (kind_of(event, vehicle.kind) != vehicle.kind) {
    throw InvalidArgument("odometry", "of another kind", "must match vehicle.kind of the configuration");
  }
  std::visit(RecordCheck{event.time_s}, event.record);
  if (const auto* control = std::get_if<AckermanControl>(&event.record)) check_drivable(*control, vehicle.ackerman);
}

}  // namespace ssjs
