/// A simulated survey of two dives, with fixes at the surface, through the online estimator while something goes wrong. docs/faults.md
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/online_survey.hpp"
#include "ssjs/simulation/auv_survey.hpp"
#include "ssjs/simulation/fault_injector.hpp"

namespace ssjs::testing {

struct FaultCase {
  std::string name;
  FaultTime when;  ///< when it is wrong; what follows is "after"
  std::function<void(ArrivingSamples&, const FaultTime&, const Rng&)> inject = [](ArrivingSamples&, const FaultTime&, const Rng&) {};
  std::function<void(OnlineSurveyConfig&)> configure = [](OnlineSurveyConfig&) {};
};

struct FaultOutcome {
  double during_m = 0.0, during_sigmas = 0.0;  ///< largest error of the live position while it lasts, and in its standard deviations
  double after_m = 0.0;                        ///< largest once recovered
  double end_m = 0.0, end_sigma_m = 0.0;       ///< at the end of the mission
  std::optional<double> recovered_s;           ///< after the end of the fault: inside three sigma for a minute
  int closures_until = 0, fixes_until = 0;     ///< between the end of the fault and then
  SurveyHealth worst = SurveyHealth::kGood;    ///< while it lasts and until then
  std::vector<std::string> notes;              ///< what the log said from its beginning until then, each text once
  SurveyStatus status;                         ///< at the end
  int failures = 0;                            ///< samples that threw
  double final_rmse_m = 0.0;                   ///< of the corrected trajectory, where the clock was not touched
  double cpu_s = 0.0;
};

inline SimulatedSurvey two_dives(std::uint64_t seed) {
  SurveyWorldConfig lines;
  lines.surface_start = true;
  lines.dives = 2;
  lines.run_in_m = 200.0;
  AuvSimulationConfig vehicle;
  vehicle.fix_interval_s = 1.0;
  vehicle.depth_gain_rad_m = 0.3;
  vehicle.dive_step_m = 1.0;
  SurveyWorld world = survey_world(lines, seed);
  world.waypoints.emplace_back(-lines.run_in_m, 0.0);  // and up at the end
  world.dives.emplace_back(std::nullopt);
  return simulate_survey(world, vehicle, seed);
}

inline FaultOutcome run_fault(const SimulatedSurvey& survey, const FaultCase& fault, std::uint64_t seed) {
  FaultOutcome outcome;
  ArrivingSamples samples = arriving(survey.ticks);
  fault.inject(samples, fault.when, Rng(seed).stream("fault"));
  OnlineSurveyConfig config;
  fault.configure(config);
  OnlineSurvey estimator(config);
  double now_s = 0.0;
  bool is_recovered = false;
  const auto concerns = [&] { return now_s >= fault.when.begin_s && !is_recovered; };
  estimator.set_log([&](const SurveyNote& note) {
    const bool is_new = std::find(outcome.notes.begin(), outcome.notes.end(), note.text) == outcome.notes.end();
    if (concerns() && note.kind != NoteKind::kClosure && is_new) outcome.notes.push_back(note.text);
  });
  const double step_s = survey.truth[1].time_s - survey.truth[0].time_s;
  bool is_inside = false;
  double inside_since_s = 0.0;
  SurveyStatus at_end_of_fault;
  double next_s = 0.0;
  bool has_ended = false;
  for (const ArrivingSample& sample : samples) {
    now_s = std::max(now_s, sample.taken_s);
    try {
      static_cast<void>(estimator.feed(sample.tick));
    } catch (const Error&) {
      ++outcome.failures;
    }
    if (now_s < next_s) continue;
    next_s = now_s + 1.0;
    std::optional<SurveyStep> step;
    try {
      step = estimator.global_T_vehicle();
    } catch (const Error&) {
      ++outcome.failures;
    }
    if (!step) continue;
    const AuvTruth& truth = survey.truth[std::min(survey.truth.size() - 1, static_cast<std::size_t>(std::lround(now_s / step_s)))];
    const Eigen::Vector2d error = step->global_T_vehicle.head<2>() - truth.world_T_vehicle.translation.head<2>();
    const Eigen::Array2d sigmas = error.array().abs() / step->covariance.diagonal().head<2>().array().sqrt();
    const double worst_sigmas = sigmas.maxCoeff<Eigen::PropagateNaN>();
    const SurveyStatus status = estimator.status();
    if (concerns()) outcome.worst = std::max(outcome.worst, status.health);
    if (fault.when.holds(now_s)) {
      outcome.during_m = std::max(outcome.during_m, error.norm());
      outcome.during_sigmas = std::max(outcome.during_sigmas, worst_sigmas);
    }
    outcome.end_m = error.norm();
    outcome.end_sigma_m = status.position_sigma_m;
    if (now_s < fault.when.end_s) continue;
    if (!has_ended) at_end_of_fault = status;
    has_ended = true;
    if (!is_recovered) {
      if (!(worst_sigmas <= 3.0)) {
        is_inside = false;
      } else if (!is_inside) {
        is_inside = true;
        inside_since_s = now_s;
        constexpr auto kFix = static_cast<std::size_t>(NavigationSensor::kFix);
        outcome.closures_until = status.loop_closures - at_end_of_fault.loop_closures;
        outcome.fixes_until = static_cast<int>(status.used[kFix] - at_end_of_fault.used[kFix]);
      }
      if (is_inside && now_s - inside_since_s >= 60.0) {
        is_recovered = true;
        outcome.recovered_s = inside_since_s - fault.when.end_s;
      }
    }
    if (is_recovered) outcome.after_m = std::max(outcome.after_m, error.norm());
  }
  outcome.status = estimator.status();
  estimator.finish();
  double sum = 0.0;
  int count = 0;
  for (const SurveyStep& step : estimator.trajectory()) {
    const auto at = static_cast<std::size_t>(std::lround(step.time_s / step_s));
    if (at >= survey.truth.size()) continue;
    sum += (step.global_T_vehicle.head<2>() - survey.truth[at].world_T_vehicle.translation.head<2>()).squaredNorm();
    ++count;
  }
  outcome.final_rmse_m = std::sqrt(sum / std::max(1, count));
  return outcome;
}

/// Every fault of docs/faults.md; those that end begin at 400 s, on the lines of the first dive.
inline std::vector<FaultCase> faults(const SimulatedSurvey& survey) {
  constexpr double kBegin = 400.0;
  const auto of = [](auto member) {
    NavigationTick tick;
    (tick.*member).emplace();
    return tick;
  };
  const NavigationTick gyro = of(&NavigationTick::gyro_rad_s);
  const NavigationTick attitude = of(&NavigationTick::roll_pitch_rad);
  const NavigationTick compass = of(&NavigationTick::compass_rad);
  const NavigationTick depth = of(&NavigationTick::depth_m);
  const NavigationTick altitude = of(&NavigationTick::altitude_m);
  const NavigationTick velocity = of(&NavigationTick::velocity);
  const NavigationTick fix = of(&NavigationTick::fix);
  const std::vector<std::pair<std::string, NavigationTick>> sensors = {
      {"gyro", gyro}, {"attitude", attitude}, {"compass", compass}, {"depth", depth}, {"altitude", altitude}, {"velocity log", velocity}};
  using Samples = ArrivingSamples;
  std::vector<FaultCase> all;
  const auto add = [&](const std::string& name, double seconds, auto inject) {
    all.push_back({name, {kBegin, kBegin + seconds}, inject});
    return &all.back();
  };
  add("none", 60.0, [](Samples&, const FaultTime&, const Rng&) {});
  add("late and out of order by up to 0.8 s, for 60 s", 60.0,
      [](Samples& s, const FaultTime& t, const Rng& rng) { delay(s, t, 0.8, rng); });
  add("late by up to 5 s, for 60 s", 60.0, [](Samples& s, const FaultTime& t, const Rng& rng) { delay(s, t, 5.0, rng); });
  const auto clock = [&](const std::string& name, double by_s, double until_s, bool gaps_are_silence) {
    all.push_back({name,
                   {kBegin, kBegin + 10.0},
                   [=](Samples& s, const FaultTime& t, const Rng&) {
                     shift_clock(s, {t.begin_s, until_s}, by_s);
                   },
                   [=](OnlineSurveyConfig& config) { config.arrival.gaps_are_silence = gaps_are_silence; }});
  };
  constexpr double kForGood = 1e9;
  clock("clock ahead by 30 s, for good", 30.0, kForGood, true);
  clock("clock back by 0.5 s, for good", -0.5, kForGood, true);
  clock("clock back by 10 s, for good", -10.0, kForGood, true);
  clock("clock back by 3 h, for good", -10800.0, kForGood, true);
  clock("clock ahead by 3 h for 0.3 s", 10800.0, kBegin + 0.3 / 5.0, true);
  clock("clock ahead by 3 h for 3 s", 10800.0, kBegin + 3.0, true);
  clock("clock ahead by 3 h, for good", 10800.0, kForGood, true);
  clock("the same, told that gaps are the clock's", 10800.0, kForGood, false);
  add("every sample twice more at its time, for 60 s", 60.0, [](Samples& s, const FaultTime& t, const Rng&) { repeat(s, t, 3); });
  add("every third sample NaN or infinite, for 60 s", 60.0,
      [](Samples& s, const FaultTime& t, const Rng&) { spoil(s, t, all_sensors(), 3); });
  for (const double seconds : {30.0, 600.0}) {
    for (const auto& [name, sensor] : sensors) {
      add(name + " silent for " + std::to_string(std::lround(seconds)) + " s", seconds,
          [sensor = sensor](Samples& s, const FaultTime& t, const Rng&) { silence(s, t, sensor); });
    }
    add("all silent for " + std::to_string(std::lround(seconds)) + " s", seconds,
        [](Samples& s, const FaultTime& t, const Rng&) { silence(s, t, all_sensors()); });
  }
  for (const auto& [name, sensor] : sensors) {
    add(name + " hangs for 120 s", 120.0, [sensor = sensor](Samples& s, const FaultTime& t, const Rng&) { hang(s, t, sensor); });
  }
  const std::vector<double> most = {1.0, 0.5, 1.0, 10.0, 10.0, 3.0};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    add("30 % outliers of the " + sensors[i].first + ", for 60 s", 60.0,
        [sensor = sensors[i].second, range = most[i]](Samples& s, const FaultTime& t, const Rng& rng) {
          add_outliers(s, t, sensor, 0.3, range, rng);
        });
  }
  const std::vector<std::pair<const char*, double>> units = {{"deg/s", 180.0 / kPi}, {"deg", 180.0 / kPi}, {"deg", 180.0 / kPi},
                                                             {"mm", 1000.0},         {"mm", 1000.0},       {"mm/s", 1000.0}};
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto inject = [sensor = sensors[i].second, factor = units[i].second](Samples& s, const FaultTime& t, const Rng&) {
      scale(s, t, sensor, factor);
    };
    add(sensors[i].first + " in " + units[i].first + " for 120 s", 120.0, inject);
    all.push_back({sensors[i].first + " in " + units[i].first + " from the start to 300 s", {0.0, 300.0}, inject});
  }
  add("10,000 sightings of nothing in 60 s", 60.0, [](Samples& s, const FaultTime& t, const Rng& rng) { flood(s, t, 10000, rng); });
  const double end_s = survey.truth.back().time_s;
  add("all silent for 950 s", 950.0, [](Samples& s, const FaultTime& t, const Rng&) { silence(s, t, all_sensors()); });
  all.push_back({"one fix in five off by up to 100 m, always", {0.0, end_s - 100.0}, [=](Samples& s, const FaultTime& t, const Rng& rng) {
                   add_outliers(s, {t.begin_s + 1.0, t.end_s}, fix, 0.2, 100.0, rng);
                 }});
  add("velocity log reads 30 % short for 300 s, unnoticed", 300.0,
      [velocity](Samples& s, const FaultTime& t, const Rng&) { scale(s, t, velocity, 0.7); });
  add("the same, and an operator sets the position at its end", 300.0, [velocity, &survey](Samples& s, const FaultTime& t, const Rng&) {
    scale(s, t, velocity, 0.7);
    const auto after = std::find_if(s.begin(), s.end(), [&](const ArrivingSample& sample) { return sample.taken_s >= t.end_s; });
    NavigationTick word = tick_at(after->tick.time_s);
    const AuvTruth* at = &survey.truth.front();
    for (const AuvTruth& truth : survey.truth) at = truth.time_s <= t.end_s ? &truth : at;
    word.fix = PositionFix{at->world_T_vehicle.translation.head<2>(), 4.0 * Eigen::Matrix2d::Identity(), true};
    s.insert(after, {word.time_s, word});
  });
  return all;
}

}  // namespace ssjs::testing
