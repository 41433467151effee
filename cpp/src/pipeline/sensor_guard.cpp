#include "ssjs/pipeline/sensor_guard.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr double kRoundedFactor = 3.0;     // what may be rounded hangs after so many times the time and the samples
constexpr double kReferenceHoldsS = 30.0;  // a value believed so long ago says nothing of the next
constexpr int kMostNeeded = 20000;
constexpr double kUnits[] = {1000.0, 1e-3, 180.0 / kPi, kPi / 180.0};

bool may_be_rounded(NavigationSensor sensor) {
  return sensor == NavigationSensor::kCompass || sensor == NavigationSensor::kDepth || sensor == NavigationSensor::kAltitude;
}

/// A change within a second that the sensor may show: a unit is suspected beyond ten of them.
double unremarkable(NavigationSensor sensor) {
  switch (sensor) {
    case NavigationSensor::kDepth:
    case NavigationSensor::kAltitude:
      return 0.5;
    case NavigationSensor::kVelocityLog:
      return 0.3;
    default:
      return 0.1;
  }
}

}  // namespace

SensorGuard::SensorGuard(const GuardConfig& config) : config_(config), gyro_(config.gyro_disagreement_rad, config.recover_samples) {
  throw_if_any(violations(config));
}

bool SensorGuard::in_range(NavigationSensor sensor, const Values& v) const {
  const double most = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
  switch (sensor) {
    case NavigationSensor::kAttitude:
      return most <= config_.max_tilt_rad;
    case NavigationSensor::kCompass:
      return most <= 2.0 * kPi + 0.01;  // either turn of it
    case NavigationSensor::kDepth:
      return v[0] >= -20.0 && v[0] <= config_.max_depth_m;  // a little above the surface for want of a zero
    case NavigationSensor::kAltitude:
      return v[0] >= 0.0 && v[0] <= config_.max_altitude_m;
    case NavigationSensor::kVelocityLog:
      return most <= config_.max_speed_m_s;
    case NavigationSensor::kGyro:
      return most <= config_.max_turn_rate_rad_s;
    default:
      return true;
  }
}

bool SensorGuard::is_other_unit(NavigationSensor sensor, double time_s, const Values& values) const {
  const Watched& of_sensor = watched_[index(sensor)];
  if (!of_sensor.believed || time_s - of_sensor.believed_s > kReferenceHoldsS || sensor == NavigationSensor::kGyro ||
      sensor == NavigationSensor::kCompass) {
    return false;  // rates are near 0 and headings go round: nothing to compare with
  }
  const double usual = unremarkable(sensor) * (1.0 + std::max(0.0, time_s - of_sensor.believed_s));
  const auto distance = [&](double factor) {
    double most = 0.0;
    for (std::size_t i = 0; i < kMostValues; ++i) most = std::max(most, std::abs(values[i] / factor - (*of_sensor.believed)[i]));
    return most;
  };
  if (distance(1.0) <= 10.0 * usual) return false;
  return std::any_of(std::begin(kUnits), std::end(kUnits), [&](double factor) { return distance(factor) <= usual; });
}

SampleFault SensorGuard::plausible(NavigationSensor sensor, double time_s, const Values& values) const {
  if (is_other_unit(sensor, time_s, values)) return SampleFault::kUnit;
  if (in_range(sensor, values)) return SampleFault::kNone;
  const bool in_another = std::any_of(std::begin(kUnits), std::end(kUnits), [&](double factor) {
    return factor > 1.0 && in_range(sensor, {values[0] / factor, values[1] / factor, values[2] / factor});
  });
  return in_another ? SampleFault::kUnit : SampleFault::kRange;
}

/// Also counts, so that it is asked once a sample.
bool SensorGuard::is_stuck(NavigationSensor sensor, double time_s, const Values& values) {
  Watched& of_sensor = watched_[index(sensor)];
  if (!of_sensor.last || *of_sensor.last != values) {
    of_sensor.last = values;
    of_sensor.same_since_s = time_s;
    of_sensor.same = 1;
    of_sensor.changes_before = ++changes_;
    return false;
  }
  ++of_sensor.same;
  const bool is_zero = std::all_of(values.begin(), values.end(), [](double value) { return value == 0.0; });
  if (!config_.stuck_s || is_zero) return false;
  const double factor = may_be_rounded(sensor) ? kRoundedFactor : 1.0;
  const bool others_move = changes_ - of_sensor.changes_before >= config_.stuck_samples;
  return others_move && of_sensor.same >= factor * config_.stuck_samples && time_s - of_sensor.same_since_s >= factor * *config_.stuck_s;
}

bool SensorGuard::believe(NavigationSensor sensor, double time_s, const Values& values) {
  Watched& of_sensor = watched_[index(sensor)];
  const bool stuck = is_stuck(sensor, time_s, values);
  const SampleFault found = plausible(sensor, time_s, values);
  if (found != SampleFault::kNone) {
    if (!of_sensor.is_doubted) of_sensor.needed = std::min(kMostNeeded, std::max(config_.recover_samples, 2 * of_sensor.needed));
    of_sensor.is_doubted = true;
    of_sensor.fault = found;
    of_sensor.good_in_a_row = 0;
  } else if (of_sensor.is_doubted && ++of_sensor.good_in_a_row >= of_sensor.needed) {
    of_sensor.is_doubted = false;
  }
  if (stuck && !of_sensor.is_doubted) of_sensor.fault = SampleFault::kStuck;
  if (stuck || of_sensor.is_doubted) {
    ++of_sensor.refused;
    return false;
  }
  of_sensor.fault = SampleFault::kNone;
  of_sensor.believed = values;
  of_sensor.believed_s = time_s;
  return true;
}

void SensorGuard::limit_sightings(NavigationTick& tick) {
  if (!config_.max_sightings_per_min || tick.sightings.empty()) return;
  const auto most = static_cast<double>(*config_.max_sightings_per_min);
  sightings_left_ = std::min(most, sightings_left_.value_or(most) + most / 60.0 * (tick.time_s - refilled_s_));
  refilled_s_ = tick.time_s;
  const auto allowed = static_cast<std::size_t>(std::max(0.0, std::floor(*sightings_left_)));
  Watched& sightings = watched_[index(NavigationSensor::kSideScan)];
  sightings.fault = tick.sightings.size() > allowed ? SampleFault::kFlood : SampleFault::kNone;
  if (tick.sightings.size() > allowed) {
    sightings.refused += static_cast<std::int64_t>(tick.sightings.size() - allowed);
    tick.sightings.resize(allowed);
  }
  *sightings_left_ -= static_cast<double>(tick.sightings.size());
}

const NavigationTick& SensorGuard::pass(const NavigationTick& arrived) {
  passed_ = arrived;  // no new memory where the sightings find room
  NavigationTick& tick = passed_;
  const double t = tick.time_s;
  if (tick.gyro_rad_s) {
    const Eigen::Vector3d& w = *tick.gyro_rad_s;
    if (!believe(NavigationSensor::kGyro, t, {w.x(), w.y(), w.z()})) tick.gyro_rad_s.reset();
  }
  if (tick.roll_pitch_rad && !believe(NavigationSensor::kAttitude, t, {tick.roll_pitch_rad->x(), tick.roll_pitch_rad->y(), 0.0})) {
    tick.roll_pitch_rad.reset();
  }
  const auto scalar = [&](NavigationSensor sensor, std::optional<double>& value) {
    if (value && !believe(sensor, t, {*value, 0.0, 0.0})) value.reset();
  };
  scalar(NavigationSensor::kCompass, tick.compass_rad);
  scalar(NavigationSensor::kDepth, tick.depth_m);
  scalar(NavigationSensor::kAltitude, tick.altitude_m);
  if (tick.velocity && tick.velocity->bottom_lock) {
    const Eigen::Vector3d& v = tick.velocity->velocity_m_s;
    if (!believe(NavigationSensor::kVelocityLog, t, {v.x(), v.y(), v.z()})) tick.velocity.reset();
  }
  gyro_.see(tick);
  if (gyro_.is_doubted()) {
    Watched& gyro = watched_[index(NavigationSensor::kGyro)];
    if (gyro.fault == SampleFault::kNone) gyro.fault = SampleFault::kAlone;
    if (tick.gyro_rad_s) ++gyro.refused;
    tick.gyro_rad_s.reset();
  }
  limit_sightings(tick);
  return tick;
}

}  // namespace ssjs
