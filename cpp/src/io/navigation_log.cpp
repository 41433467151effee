#include "ssjs/io/navigation_log.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/io/log_checks.hpp"

namespace ssjs {
void NavigationLog::add_attitude(const Column& time_s, const Table& roll_pitch_yaw_rad) {
  check_rows("attitude", roll_pitch_yaw_rad.rows(), time_s.size());
  check_columns("attitude", roll_pitch_yaw_rad.cols(), 3);
  check_times("attitude", time_s);
  check_finite("attitude", "roll, pitch, yaw", roll_pitch_yaw_rad);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    tick.roll_pitch_rad = Eigen::Vector2d(roll_pitch_yaw_rad(i, 0), roll_pitch_yaw_rad(i, 1));
    tick.compass_rad = roll_pitch_yaw_rad(i, 2);
    add(std::move(tick));
  }
}

void NavigationLog::add_gyro(const Column& time_s, const Table& body_rates_rad_s) {
  check_rows("gyro", body_rates_rad_s.rows(), time_s.size());
  check_columns("gyro", body_rates_rad_s.cols(), 3);
  check_times("gyro", time_s);
  check_finite("gyro", "body rates", body_rates_rad_s);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    tick.gyro_rad_s = Eigen::Vector3d(body_rates_rad_s.row(i));
    add(std::move(tick));
  }
}

void NavigationLog::add_depth(const Column& time_s, const Column& depth_m) {
  check_rows("depth_m", depth_m.size(), time_s.size());
  check_times("depth", time_s);
  check_finite("depth", "depth_m", depth_m);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    tick.depth_m = depth_m(i);
    add(std::move(tick));
  }
}

void NavigationLog::add_altitude(const Column& time_s, const Column& altitude_m) {
  check_rows("altitude_m", altitude_m.size(), time_s.size());
  check_times("altitude", time_s);
  check_finite("altitude", "altitude_m", altitude_m);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    tick.altitude_m = altitude_m(i);
    add(std::move(tick));
  }
}

void NavigationLog::add_velocity(const Column& time_s, const Table& velocity_m_s, const std::vector<bool>& bottom_lock) {
  check_rows("velocity", velocity_m_s.rows(), time_s.size());
  check_columns("velocity", velocity_m_s.cols(), 3);
  check_rows("bottom_lock", static_cast<Eigen::Index>(bottom_lock.size()), time_s.size());
  check_times("velocity", time_s);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    tick.velocity.emplace();
    tick.velocity->bottom_lock = bottom_lock[static_cast<std::size_t>(i)];
    if (tick.velocity->bottom_lock) {
      check_finite("velocity with bottom lock,", "velocity_m_s", velocity_m_s.row(i));
      tick.velocity->velocity_m_s = velocity_m_s.row(i);
    }
    add(std::move(tick));
  }
}

void NavigationLog::add_sightings(const Column& time_s, const Table& vehicle_p_point, const Table& covariance,
                                  const std::optional<std::vector<std::int64_t>>& landmark_id) {
  check_rows("points", vehicle_p_point.rows(), time_s.size());
  check_columns("points", vehicle_p_point.cols(), 3);
  if (covariance.rows() > 0) {
    check_rows("point covariance", covariance.rows(), time_s.size());
    check_columns("point covariance", covariance.cols(), 6);
  }
  if (landmark_id) check_rows("landmark_id", static_cast<Eigen::Index>(landmark_id->size()), time_s.size());
  check_times("points", time_s);
  check_finite("points", "x, y, z", vehicle_p_point);
  check_finite("points", "covariance", covariance);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    SideScanSighting sighting;
    sighting.vehicle_p_point = vehicle_p_point.row(i);
    if (covariance.rows() > 0) {
      Eigen::Matrix3d P;
      P << covariance(i, 0), covariance(i, 1), covariance(i, 2),  //
          covariance(i, 1), covariance(i, 3), covariance(i, 4),   //
          covariance(i, 2), covariance(i, 4), covariance(i, 5);
      sighting.covariance = P;
    }
    if (landmark_id && (*landmark_id)[static_cast<std::size_t>(i)] >= 0) sighting.landmark_id = (*landmark_id)[static_cast<std::size_t>(i)];
    NavigationTick tick = tick_at(time_s(i));
    tick.sightings.push_back(sighting);
    add(std::move(tick));
  }
}

void NavigationLog::add_fixes(const Column& time_s, const Table& world_p_vehicle, const Column& sigma_m) {
  check_rows("fixes", world_p_vehicle.rows(), time_s.size());
  check_columns("fixes", world_p_vehicle.cols(), 2);
  check_rows("sigma_m", sigma_m.size(), time_s.size());
  check_times("fixes", time_s);
  check_finite("fixes", "x, y", world_p_vehicle);
  check_finite("fixes", "sigma_m", sigma_m);
  make_room(time_s.size());
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    if (!(sigma_m(i) > 0.0)) throw InvalidArgument("fixes, row " + std::to_string(i + 1) + ", sigma_m", sigma_m(i), "must be positive");
    NavigationTick tick = tick_at(time_s(i));
    tick.fix = PositionFix{world_p_vehicle.row(i).transpose(), sigma_m(i) * sigma_m(i) * Eigen::Matrix2d::Identity(), false};
    add(std::move(tick));
  }
}

void NavigationLog::add_frames(const Column& time_s, const Table& pixel, const std::vector<std::int64_t>& count,
                               const Eigen::Ref<const Eigen::MatrixXf>& descriptor,
                               const std::optional<std::vector<std::int64_t>>& landmark_id) {
  check_rows("frames, count", static_cast<Eigen::Index>(count.size()), time_s.size());
  check_columns("frames, pixel", pixel.cols(), 2);
  check_times("frames", time_s);
  check_finite("frames, pixel", "u, v", pixel);
  if (descriptor.rows() > 0) {
    check_rows("frames, descriptor", descriptor.rows(), pixel.rows());
    check_finite("frames, descriptor", "numbers", descriptor.cast<double>());
  }
  if (landmark_id) check_rows("frames, landmark_id", static_cast<Eigen::Index>(landmark_id->size()), pixel.rows());
  Eigen::Index sightings = 0;
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (count[i] < 0 || count[i] > pixel.rows() - sightings) {
      throw InvalidArgument("frames, row " + std::to_string(i + 1) + ", count", static_cast<double>(count[i]),
                            "must not be negative nor more than the sightings that are left");
    }
    sightings += count[i];
  }
  if (sightings != pixel.rows()) {
    throw InvalidArgument("frames, pixel", std::to_string(pixel.rows()) + " rows",
                          "must be as many as count adds up to, " + std::to_string(sightings));
  }
  make_room(time_s.size());
  Eigen::Index row = 0;
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    NavigationTick tick = tick_at(time_s(i));
    std::vector<CameraSighting>& seen = tick.frame.emplace().sightings;
    seen.resize(static_cast<std::size_t>(count[static_cast<std::size_t>(i)]));
    for (CameraSighting& sighting : seen) {
      sighting.pixel = pixel.row(row);
      if (descriptor.rows() > 0) sighting.descriptor = descriptor.row(row);
      const std::int64_t id = landmark_id ? (*landmark_id)[static_cast<std::size_t>(row)] : -1;
      if (id >= 0) sighting.landmark_id = id;
      ++row;
    }
    add(std::move(tick));
  }
}

/// Sensors that speak at the same times share their ticks before the next sensor comes: a long log takes little more than its ticks.
void NavigationLog::make_room(Eigen::Index samples) {
  (void)ticks();
  ticks_.reserve(ticks_.size() + static_cast<std::size_t>(samples));
}

const std::vector<NavigationTick>& NavigationLog::ticks() {
  if (!merged_) {
    std::stable_sort(ticks_.begin(), ticks_.end(), [](const NavigationTick& a, const NavigationTick& b) { return a.time_s < b.time_s; });
    std::vector<NavigationTick> merged;
    for (NavigationTick& tick : ticks_) {
      if (!merged.empty() && merged.back().time_s == tick.time_s) {
        take_in(merged.back(), tick);
      } else {
        merged.push_back(std::move(tick));
      }
    }
    merged.shrink_to_fit();
    ticks_ = std::move(merged);
    merged_ = true;
  }
  return ticks_;
}

}  // namespace ssjs
