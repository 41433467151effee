#include "ssjs/simulation/fault_injector.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace ssjs {
namespace {

constexpr std::int64_t kFirstFloodId = 2'000'000;

/// Calls action(values) with the numbers of each sensor in the tick that also speaks in `sensors`, as an array to change.
template <class Action>
void for_values(NavigationTick& tick, const NavigationTick& sensors, const Action& action) {
  if (tick.gyro_rad_s && sensors.gyro_rad_s) action(tick.gyro_rad_s->data(), 3);
  if (tick.roll_pitch_rad && sensors.roll_pitch_rad) action(tick.roll_pitch_rad->data(), 2);
  if (tick.compass_rad && sensors.compass_rad) action(&*tick.compass_rad, 1);
  if (tick.depth_m && sensors.depth_m) action(&*tick.depth_m, 1);
  if (tick.altitude_m && sensors.altitude_m) action(&*tick.altitude_m, 1);
  if (tick.velocity && sensors.velocity) action(tick.velocity->velocity_m_s.data(), 3);
  if (tick.fix && sensors.fix) action(tick.fix->world_p_vehicle.data(), 2);
}

bool speaks(const NavigationTick& tick, const NavigationTick& sensors) {
  return share_a_sensor(tick, sensors) || (!tick.sightings.empty() && !sensors.sightings.empty());
}

}  // namespace

ArrivingSamples arriving(const std::vector<NavigationTick>& ticks) {
  ArrivingSamples samples;
  for (const NavigationTick& tick : ticks) {
    const auto add = [&](auto NavigationTick::*member, bool there) {
      if (!there) return;
      NavigationTick one = tick_at(tick.time_s);
      one.*member = tick.*member;
      samples.push_back({tick.time_s, std::move(one)});
    };
    add(&NavigationTick::gyro_rad_s, tick.gyro_rad_s.has_value());
    add(&NavigationTick::roll_pitch_rad, tick.roll_pitch_rad.has_value());
    add(&NavigationTick::compass_rad, tick.compass_rad.has_value());
    add(&NavigationTick::depth_m, tick.depth_m.has_value());
    add(&NavigationTick::altitude_m, tick.altitude_m.has_value());
    add(&NavigationTick::velocity, tick.velocity.has_value());
    add(&NavigationTick::fix, tick.fix.has_value());
    add(&NavigationTick::sightings, !tick.sightings.empty());
  }
  return samples;
}

NavigationTick all_sensors() {
  NavigationTick tick;
  tick.gyro_rad_s.emplace();
  tick.roll_pitch_rad.emplace();
  tick.compass_rad.emplace();
  tick.depth_m.emplace();
  tick.altitude_m.emplace();
  tick.velocity.emplace();
  tick.fix.emplace();
  tick.sightings.emplace_back();
  return tick;
}

void delay(ArrivingSamples& samples, const FaultTime& when, double most_s, Rng rng) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double late_s = when.holds(samples[i].taken_s) ? rng.uniform(0.0, most_s) : 0.0;
    order.emplace_back(samples[i].taken_s + late_s, i);
  }
  std::sort(order.begin(), order.end());
  ArrivingSamples delayed;
  for (const auto& [arrives_s, i] : order) delayed.push_back(std::move(samples[i]));
  samples = std::move(delayed);
}

void shift_clock(ArrivingSamples& samples, const FaultTime& when, double shift_s) {
  for (ArrivingSample& sample : samples) {
    if (when.holds(sample.taken_s)) sample.tick.time_s += shift_s;
  }
}

void repeat(ArrivingSamples& samples, const FaultTime& when, int times) {
  ArrivingSamples repeated;
  for (ArrivingSample& sample : samples) {
    const bool is_repeated = when.holds(sample.taken_s) && sample.tick.sightings.empty();
    for (int i = 1; is_repeated && i < times; ++i) {
      ArrivingSample again = sample;
      for_values(again.tick, all_sensors(), [&](double* values, int) { values[0] += 0.1 * i; });
      repeated.push_back(std::move(sample));
      sample = std::move(again);
    }
    repeated.push_back(std::move(sample));
  }
  samples = std::move(repeated);
}

void spoil(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, int every) {
  int count = 0;
  for (ArrivingSample& sample : samples) {
    if (!when.holds(sample.taken_s) || !speaks(sample.tick, sensors) || ++count % every != 0) continue;
    const double nothing = count % (2 * every) == 0 ? std::nan("") : std::numeric_limits<double>::infinity();
    for_values(sample.tick, sensors, [&](double* values, int) { values[0] = nothing; });
    for (SideScanSighting& sighting : sample.tick.sightings) sighting.vehicle_p_point.y() = nothing;
  }
}

void silence(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors) {
  const auto is_silent = [&](const ArrivingSample& sample) { return when.holds(sample.taken_s) && speaks(sample.tick, sensors); };
  samples.erase(std::remove_if(samples.begin(), samples.end(), is_silent), samples.end());
}

void hang(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors) {
  NavigationTick first;
  for (ArrivingSample& sample : samples) {
    if (!when.holds(sample.taken_s) || !share_a_sensor(sample.tick, sensors)) continue;
    if (!share_a_sensor(sample.tick, first)) take_in(first, sample.tick);
    NavigationTick& tick = sample.tick;
    const auto say = [](auto& value, const auto& again) {
      if (value) value = again;
    };
    say(tick.gyro_rad_s, first.gyro_rad_s);
    say(tick.roll_pitch_rad, first.roll_pitch_rad);
    say(tick.compass_rad, first.compass_rad);
    say(tick.depth_m, first.depth_m);
    say(tick.altitude_m, first.altitude_m);
    if (tick.velocity) tick.velocity = first.velocity;
    if (tick.fix) tick.fix = first.fix;
  }
}

void add_outliers(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, double fraction, double most, Rng rng) {
  for (ArrivingSample& sample : samples) {
    if (!when.holds(sample.taken_s) || !speaks(sample.tick, sensors) || rng.uniform() >= fraction) continue;
    for_values(sample.tick, sensors, [&](double* values, int size) {
      for (int i = 0; i < size; ++i) values[i] += rng.uniform(-most, most);
    });
  }
}

void scale(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, double factor) {
  for (ArrivingSample& sample : samples) {
    if (!when.holds(sample.taken_s)) continue;
    for_values(sample.tick, sensors, [&](double* values, int size) {
      for (int i = 0; i < size; ++i) values[i] *= factor;
    });
  }
}

void flood(ArrivingSamples& samples, const FaultTime& when, int sightings, Rng rng) {
  ArrivingSamples all;
  const double every_s = (when.end_s - when.begin_s) / sightings;
  int count = 0;
  for (ArrivingSample& sample : samples) {
    for (; count < sightings && when.begin_s + count * every_s <= sample.taken_s; ++count) {
      NavigationTick tick = tick_at(when.begin_s + count * every_s);
      SideScanSighting sighting;
      const double across = std::copysign(rng.uniform(3.0, 30.0), rng.uniform(-1.0, 1.0));
      sighting.vehicle_p_point = {0.0, across, 4.0};
      sighting.landmark_id = kFirstFloodId + count;
      tick.sightings.push_back(sighting);
      all.push_back({tick.time_s, std::move(tick)});
    }
    all.push_back(std::move(sample));
  }
  samples = std::move(all);
}

void displace_fixes(ArrivingSamples& samples, const FaultTime& when, const Eigen::Vector2d& by) {
  for (ArrivingSample& sample : samples) {
    if (when.holds(sample.taken_s) && sample.tick.fix) sample.tick.fix->world_p_vehicle += by;
  }
}

}  // namespace ssjs
