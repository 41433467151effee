#include "ssjs/pipeline/survey_health.hpp"

namespace ssjs {
namespace {

constexpr int kManyRefused = 10;  // in a row

std::size_t index(NavigationSensor sensor) { return static_cast<std::size_t>(sensor); }

}  // namespace

void SensorWatch::see(const NavigationTick& arrived) {
  const auto spoke = [&](NavigationSensor sensor, bool there) {
    if (!there) return;
    sensors_[index(sensor)].spoke = true;
    sensors_[index(sensor)].spoke_s = arrived.time_s;
  };
  spoke(NavigationSensor::kAttitude, arrived.roll_pitch_rad.has_value());
  spoke(NavigationSensor::kCompass, arrived.compass_rad.has_value());
  spoke(NavigationSensor::kDepth, arrived.depth_m.has_value());
  spoke(NavigationSensor::kAltitude, arrived.altitude_m.has_value());
  spoke(NavigationSensor::kVelocityLog, arrived.velocity && arrived.velocity->bottom_lock);
  spoke(NavigationSensor::kSideScan, !arrived.sightings.empty());
  spoke(NavigationSensor::kCamera, arrived.frame.has_value());
  spoke(NavigationSensor::kFix, arrived.fix.has_value());
  spoke(NavigationSensor::kGyro, arrived.gyro_rad_s.has_value());
}

void SensorWatch::see(NavigationSensor sensor, double time_s, int used, int refused) {
  Sensor& of_sensor = sensors_[index(sensor)];
  if (used > 0) {
    of_sensor.was_used = true;
    of_sensor.used_s = time_s;
    of_sensor.refused_in_a_row = 0;
  }
  of_sensor.refused_in_a_row += refused;
}

SensorState SensorWatch::state(NavigationSensor sensor, double time_s, double silence_s, const SensorGuard& guard) const {
  const Sensor& of_sensor = sensors_[index(sensor)];
  if (!of_sensor.spoke) return SensorState::kUnheard;
  if (speaks_always(sensor) && time_s - of_sensor.spoke_s > silence_s) return SensorState::kSilent;
  switch (guard.fault(sensor)) {
    case SampleFault::kStuck:
      return SensorState::kStuck;
    case SampleFault::kUnit:
      return SensorState::kWrongUnit;
    case SampleFault::kRange:
    case SampleFault::kFlood:
    case SampleFault::kAlone:
      return SensorState::kRefused;
    case SampleFault::kNone:
      break;
  }
  return of_sensor.refused_in_a_row >= kManyRefused ? SensorState::kRefused : SensorState::kGood;
}

double SensorWatch::unused_s(NavigationSensor sensor, double time_s) const {
  const Sensor& of_sensor = sensors_[index(sensor)];
  return of_sensor.was_used ? time_s - of_sensor.used_s : -1.0;
}

const char* name_of(NavigationSensor sensor) {
  constexpr std::array<const char*, kNavigationSensors> kNames = {"attitude",  "compass", "depth", "altitude", "velocity log",
                                                                  "sightings", "fix",     "gyro",  "camera"};
  return kNames[index(sensor)];
}

const char* name_of(SensorState state) {
  constexpr std::array<const char*, 6> kNames = {"unheard", "good", "silent", "refused", "stuck", "in another unit, it seems"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string advice_for(NavigationSensor sensor, SensorState state) {
  if (state == SensorState::kGood || state == SensorState::kUnheard) return {};
  const std::string name = name_of(sensor);
  if (state == SensorState::kWrongUnit) return name + " seems to come in another unit: mend the driver; it is not used";
  if (state == SensorState::kStuck) return name + " hangs: restart it; it is not used";
  if (sensor == NavigationSensor::kVelocityLog) {
    return state == SensorState::kSilent ? "no velocity over the bottom: the position drifts; go nearer to the bottom, or surface for a fix"
                                         : "velocity log refused: check its mounting and noise; surface for a fix";
  }
  if (sensor == NavigationSensor::kGyro && state == SensorState::kRefused) {
    return "gyro turns otherwise than attitude and compass: check its unit, its axes and its driver; it is not used";
  }
  if (sensor == NavigationSensor::kSideScan) return "more sightings than there can be: raise the detector's threshold";
  if (sensor == NavigationSensor::kFix) return "fixes contradict the estimate: check their frame, or set the pose";
  return name + (state == SensorState::kSilent ? " silent: check it and its driver" : " refused: check its mounting and noise");
}

}  // namespace ssjs
