/// The log of an underwater vehicle in memory: the sensors' own records, merged into ticks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/features/navigation_tick.hpp"

namespace ssjs {

/// Each add_ takes one sensor's records, times (s) non-decreasing and everything finite (InvalidArgument names the row otherwise); rows
/// count from 1. Samples of the same time make one tick; of several samples of one sensor at one time the last is taken, but every
/// sighting counts.
class NavigationLog {
 public:
  using Column = Eigen::Ref<const Eigen::VectorXd>;
  using Table = Eigen::Ref<const Eigen::MatrixXd>;

  /// roll, pitch, yaw (n x 3, rad); yaw is the compass.
  void add_attitude(const Column& time_s, const Table& roll_pitch_yaw_rad);
  void add_gyro(const Column& time_s, const Table& body_rates_rad_s);  ///< n x 3
  void add_depth(const Column& time_s, const Column& depth_m);
  void add_altitude(const Column& time_s, const Column& altitude_m);
  /// velocity: n x 3, axes of the instrument; without bottom lock it may be anything.
  void add_velocity(const Column& time_s, const Table& velocity_m_s, const std::vector<bool>& bottom_lock);
  /// point: n x 3, body frame. covariance: n x 6 (row-major upper triangle), or no rows: the sensor's. A negative landmark_id is unknown.
  void add_sightings(const Column& time_s, const Table& vehicle_p_point, const Table& covariance,
                     const std::optional<std::vector<std::int64_t>>& landmark_id);

  /// position: n x 2, world frame, m; sigma_m: of each coordinate.
  void add_fixes(const Column& time_s, const Table& world_p_vehicle, const Column& sigma_m);

  /// A frame a time, which may show nothing. pixel: m x 2, u and v of the corrected frame, those of the first frame first; count: how many
  /// of them each frame has. descriptor: m x d, or no rows: not known. A negative landmark_id is unknown.
  void add_frames(const Column& time_s, const Table& pixel, const std::vector<std::int64_t>& count,
                  const Eigen::Ref<const Eigen::MatrixXf>& descriptor, const std::optional<std::vector<std::int64_t>>& landmark_id);

  [[nodiscard]] const std::vector<NavigationTick>& ticks();

 private:
  /// A tick with only this sample.
  void add(NavigationTick tick) {
    ticks_.push_back(std::move(tick));
    merged_ = false;
  }
  void make_room(Eigen::Index samples);
  std::vector<NavigationTick> ticks_;
  bool merged_ = true;
};

}  // namespace ssjs
