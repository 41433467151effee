/// A log of events in memory, merged by time from the sensors' own records.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/features/event.hpp"

namespace ssjs {

/// Each add_ takes one sensor's records, times (s) non-decreasing and everything finite (InvalidArgument names the row otherwise);
/// rows count from 1. At equal times odometry comes before observations, and earlier added before later added.
class EventLog {
 public:
  using Column = Eigen::Ref<const Eigen::VectorXd>;

  void add_ackerman(const Column& time_s, const Column& speed_m_s, const Column& steering_rad);
  void add_velocity(const Column& time_s, const Column& speed_m_s, const Column& turn_rate_rad_s);
  /// covariance: n x 6, row-major upper triangle of (x, y, heading) in the frame of the old pose.
  void add_increments(const Column& time_s, const Column& dx_m, const Column& dy_m, const Column& dheading_rad,
                      const Eigen::Ref<const Eigen::MatrixXd>& covariance);
  /// covariance: n x 3 (var range, cov, var bearing). Consecutive rows of equal time form one scan. A negative landmark_id means unknown.
  void add_features(const Column& time_s, const Column& range_m, const Column& bearing_rad,
                    const Eigen::Ref<const Eigen::MatrixXd>& covariance, const std::optional<std::vector<std::int64_t>>& landmark_id);
  /// range_m: n x beams; ranges that are not finite mean no return.
  void add_scans(const Column& time_s, const Eigen::Ref<const Eigen::MatrixXd>& range_m, double first_angle_rad, double step_rad);
  /// Hits of a forward-looking sonar; consecutive rows of equal time form one image.
  void add_sonar_hits(const Column& time_s, const Column& range_m, const Column& bearing_rad);
  void add(Event event) {
    events_.push_back(std::move(event));
    sorted_ = false;
  }

  /// In the order of time.
  [[nodiscard]] const std::vector<Event>& events();

 private:
  std::vector<Event> events_;
  bool sorted_ = true;
};

}  // namespace ssjs
