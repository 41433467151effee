#include "ssjs/io/event_log.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/io/log_checks.hpp"

namespace ssjs {
namespace {

bool is_observation(const Event& event) {
  return std::holds_alternative<Features>(event.record) || std::holds_alternative<LaserScan>(event.record) ||
         std::holds_alternative<SonarHits>(event.record);
}

}  // namespace

void EventLog::add_ackerman(const Column& time_s, const Column& speed_m_s, const Column& steering_rad) {
  check_rows("speed_m_s", speed_m_s.size(), time_s.size());
  check_rows("steering_rad", steering_rad.size(), time_s.size());
  check_times("odometry", time_s);
  check_finite("odometry", "speed_m_s", speed_m_s);
  check_finite("odometry", "steering_rad", steering_rad);
  for (Eigen::Index i = 0; i < time_s.size(); ++i) add({time_s(i), AckermanControl{speed_m_s(i), steering_rad(i)}});
}

void EventLog::add_velocity(const Column& time_s, const Column& speed_m_s, const Column& turn_rate_rad_s) {
  check_rows("speed_m_s", speed_m_s.size(), time_s.size());
  check_rows("turn_rate_rad_s", turn_rate_rad_s.size(), time_s.size());
  check_times("odometry", time_s);
  check_finite("odometry", "speed_m_s", speed_m_s);
  check_finite("odometry", "turn_rate_rad_s", turn_rate_rad_s);
  for (Eigen::Index i = 0; i < time_s.size(); ++i) add({time_s(i), VelocityControl{speed_m_s(i), turn_rate_rad_s(i)}});
}

void EventLog::add_increments(const Column& time_s, const Column& dx_m, const Column& dy_m, const Column& dheading_rad,
                              const Eigen::Ref<const Eigen::MatrixXd>& covariance) {
  check_rows("dx_m", dx_m.size(), time_s.size());
  check_rows("dy_m", dy_m.size(), time_s.size());
  check_rows("dheading_rad", dheading_rad.size(), time_s.size());
  check_rows("odometry covariance", covariance.rows(), time_s.size());
  check_columns("odometry covariance", covariance.cols(), 6);
  check_times("odometry", time_s);
  check_finite("odometry", "dx_m", dx_m);
  check_finite("odometry", "dy_m", dy_m);
  check_finite("odometry", "dheading_rad", dheading_rad);
  check_finite("odometry", "covariance", covariance);
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    Eigen::Matrix3d P;
    P << covariance(i, 0), covariance(i, 1), covariance(i, 2),  //
        covariance(i, 1), covariance(i, 3), covariance(i, 4),   //
        covariance(i, 2), covariance(i, 4), covariance(i, 5);
    add({time_s(i), OdometryIncrement{{{dx_m(i), dy_m(i), wrap_angle(dheading_rad(i))}, P}}});
  }
}

void EventLog::add_features(const Column& time_s, const Column& range_m, const Column& bearing_rad,
                            const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                            const std::optional<std::vector<std::int64_t>>& landmark_id) {
  check_rows("range_m", range_m.size(), time_s.size());
  check_rows("bearing_rad", bearing_rad.size(), time_s.size());
  check_rows("observation covariance", covariance.rows(), time_s.size());
  check_columns("observation covariance", covariance.cols(), 3);
  if (landmark_id) check_rows("landmark_id", static_cast<Eigen::Index>(landmark_id->size()), time_s.size());
  check_times("observations", time_s);
  check_finite("observations", "range_m", range_m);
  check_finite("observations", "bearing_rad", bearing_rad);
  check_finite("observations", "covariance", covariance);
  for (Eigen::Index i = 0; i < time_s.size();) {
    Features scan;
    const double time = time_s(i);
    for (; i < time_s.size() && time_s(i) == time; ++i) {
      Feature feature;
      feature.range_bearing << range_m(i), wrap_angle(bearing_rad(i));
      feature.covariance << covariance(i, 0), covariance(i, 1), covariance(i, 1), covariance(i, 2);
      if (landmark_id && (*landmark_id)[static_cast<std::size_t>(i)] >= 0)
        feature.landmark_id = (*landmark_id)[static_cast<std::size_t>(i)];
      scan.push_back(feature);
    }
    add({time, std::move(scan)});
  }
}

void EventLog::add_scans(const Column& time_s, const Eigen::Ref<const Eigen::MatrixXd>& range_m, double first_angle_rad, double step_rad) {
  check_rows("range_m", range_m.rows(), time_s.size());
  check_times("scans", time_s);
  if (!std::isfinite(first_angle_rad)) throw InvalidArgument("first_angle_rad", first_angle_rad, "must be finite");
  if (!(std::isfinite(step_rad) && step_rad != 0.0)) throw InvalidArgument("step_rad", step_rad, "must be finite and not zero");
  for (Eigen::Index i = 0; i < time_s.size(); ++i) add({time_s(i), LaserScan{range_m.row(i).transpose(), first_angle_rad, step_rad}});
}

void EventLog::add_sonar_hits(const Column& time_s, const Column& range_m, const Column& bearing_rad) {
  check_rows("range_m", range_m.size(), time_s.size());
  check_rows("bearing_rad", bearing_rad.size(), time_s.size());
  check_times("sonar hits", time_s);
  check_finite("sonar hits", "range_m", range_m);
  check_finite("sonar hits", "bearing_rad", bearing_rad);
  for (Eigen::Index i = 0; i < time_s.size();) {
    SonarHits image;
    const double time = time_s(i);
    for (; i < time_s.size() && time_s(i) == time; ++i) image.range_bearing.emplace_back(range_m(i), bearing_rad(i));
    add({time, std::move(image)});
  }
}

const std::vector<Event>& EventLog::events() {
  if (!sorted_) {
    std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
      if (a.time_s != b.time_s) return a.time_s < b.time_s;
      return is_observation(a) < is_observation(b);
    });
    sorted_ = true;
  }
  return events_;
}

}  // namespace ssjs
