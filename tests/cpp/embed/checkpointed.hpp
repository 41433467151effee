/// Online surveys to be interrupted: what is fed, and what has to come out, as bytes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/base/config_text.hpp"
#include "ssjs/pipeline/online_survey.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs::testing {

using Settings = std::vector<std::pair<std::string, std::string>>;

inline OnlineSurveyConfig configured(const Settings& settings) {
  OnlineSurveyConfig config;
  for (const auto& [key, value] : settings) set_field(config, key, value);
  return config;
}

/// Three lines and a cross line over forty landmarks: a few submaps that meet again.
inline std::vector<NavigationTick> small_survey(std::uint64_t seed, bool with_fixes = false) {
  SurveyWorldConfig world;
  world.lines = 3;
  world.line_length_m = 90.0;
  world.cross_lines = 1;
  world.landmarks = 40;
  AuvSimulationConfig config;
  config.velocity_outages = {{60.0, 75.0}};
  config.sample_loss_fraction = 0.02;
  config.clutter_per_s = 0.05;
  SimulatedSurvey survey = simulate_survey(survey_world(world, seed), config, seed);
  if (!with_fixes) return survey.ticks;
  double next_s = 30.0;
  for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
    if (survey.ticks[i].time_s < next_s) continue;
    PositionFix fix;
    fix.world_p_vehicle = survey.truth[i].world_T_vehicle.translation.head<2>();
    if (next_s > 100.0) fix.world_p_vehicle.x() += 80.0;  // contradicts those before: refused, then believed
    survey.ticks[i].fix = fix;
    next_s += 15.0;
  }
  return survey.ticks;
}

/// The same ticks late and out of order within a window of 1 s, a few of them twice, and stamps from a clock that jumps.
inline std::vector<NavigationTick> unruly(const std::vector<NavigationTick>& ticks, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto chance = [&](double p) { return static_cast<double>(random() % 10000U) < 10000.0 * p; };
  std::vector<std::pair<double, NavigationTick>> arriving;
  for (const NavigationTick& tick : ticks) {
    const double at_s = tick.time_s + 0.9 * static_cast<double>(random() % 1000U) / 1000.0;
    arriving.emplace_back(at_s, tick);
    if (chance(0.01)) arriving.emplace_back(at_s + 0.01, tick);
    if (chance(0.01)) arriving.emplace_back(at_s, tick_at(tick.time_s + 1e5));
    if (chance(0.01)) arriving.emplace_back(at_s + 30.0, tick);
  }
  std::stable_sort(arriving.begin(), arriving.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<NavigationTick> all;
  for (auto& [at_s, tick] : arriving) all.push_back(std::move(tick));
  return all;
}

/// What the survey says of itself now, to the bit.
inline std::string said_by(OnlineSurvey& survey) {
  Archive a;
  const auto put = [&](auto value) { a("", value); };
  const auto put_step = [&](const SurveyStep& step) {
    put(step.time_s);
    put(step.global_T_vehicle);
    put(step.covariance);
  };
  for (const SurveyStep& step : survey.trajectory()) put_step(step);
  for (const SurveyLandmark& landmark : survey.landmarks()) {
    put(landmark.position);
    put(landmark.covariance);
    put(landmark.landmark);
    put(landmark.maps);
    put(landmark.seen_s);
  }
  if (const auto step = survey.global_T_vehicle()) put_step(*step);
  const SurveyStatus status = survey.status();
  put(static_cast<int>(status.health));
  put(status.arrivals);
  put(status.silent_for_s);
  put(status.used);
  put(status.refused);
  put(std::vector<int>{status.submaps, status.landmarks, status.loop_closures, status.compass_jumps});
  return a.take_bytes();
}

}  // namespace ssjs::testing
