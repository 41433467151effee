/// A simulated survey as the samples that a vehicle feeds one by one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <variant>
#include <vector>

#include "ssjs/embed/online.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs::testing {

using Sample =
    std::variant<online::Gyro, online::Attitude, online::Compass, online::Depth, online::Altitude, online::Velocity, online::Sighting>;

struct Arriving {
  double at_s;
  Sample sample;
};

inline SimulatedSurvey survey(std::uint64_t seed) {
  return simulate_survey(survey_world(SurveyWorldConfig{}, seed), AuvSimulationConfig{}, seed);
}

/// Every sample by itself, in the order of the ticks.
inline std::vector<Arriving> samples_of(const std::vector<NavigationTick>& ticks) {
  std::vector<Arriving> samples;
  for (const NavigationTick& tick : ticks) {
    const double t = tick.time_s;
    if (tick.gyro_rad_s) samples.push_back({t, online::Gyro{t, {tick.gyro_rad_s->x(), tick.gyro_rad_s->y(), tick.gyro_rad_s->z()}}});
    if (tick.roll_pitch_rad) samples.push_back({t, online::Attitude{t, tick.roll_pitch_rad->x(), tick.roll_pitch_rad->y()}});
    if (tick.compass_rad) samples.push_back({t, online::Compass{t, *tick.compass_rad}});
    if (tick.depth_m) samples.push_back({t, online::Depth{t, *tick.depth_m}});
    if (tick.altitude_m) samples.push_back({t, online::Altitude{t, *tick.altitude_m}});
    if (tick.velocity) {
      const Eigen::Vector3d& v = tick.velocity->velocity_m_s;
      samples.push_back({t, online::Velocity{t, {v.x(), v.y(), v.z()}, tick.velocity->bottom_lock}});
    }
    for (const SideScanSighting& sighting : tick.sightings) {
      const Eigen::Vector3d& p = sighting.vehicle_p_point;
      online::Sighting sample{t, {p.x(), p.y(), p.z()}, sighting.covariance.has_value(), {}, sighting.landmark_id.value_or(-1)};
      if (sighting.covariance) std::copy_n(sighting.covariance->data(), 9, sample.covariance_m2);
      samples.push_back({t, sample});
    }
  }
  return samples;
}

inline online::Arrival feed(online::Estimator& estimator, const Sample& sample) {
  return std::visit([&](const auto& each) { return estimator.feed(each); }, sample);
}

}  // namespace ssjs::testing
