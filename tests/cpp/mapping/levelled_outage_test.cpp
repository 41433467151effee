/// Ten minutes without a sensor: what the maps claim of it. docs/math/auv.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "mapping/survey_run.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

constexpr double kBegin_s = 300.0;
constexpr double kEnd_s = 900.0;

enum class Silent { kNothing, kVelocity, kGyro, kCompass, kGyroAndCompass, kAttitude, kDepth, kAltitude, kEverything };

/// Normalised errors of the maps that lie in the outage, at least in part.
struct Outage {
  int maps = 0;
  double per_dof = 0.0, worst_per_dof = 0.0;
  double position = 0.0;  ///< of the exit, mean: 2 degrees of freedom
};

SimulatedSurvey survey_with(Silent silent, std::uint64_t seed) {
  SurveyWorldConfig world;
  world.lines = 7;
  world.line_length_m = 250.0;
  AuvSimulationConfig simulation;
  if (silent == Silent::kVelocity) simulation.velocity_outages = {{kBegin_s, kEnd_s}};
  SimulatedSurvey survey = simulate_survey(survey_world(world, seed), simulation, seed);
  std::vector<NavigationTick> ticks;
  for (NavigationTick tick : survey.ticks) {
    if (tick.time_s > kBegin_s && tick.time_s < kEnd_s) {
      if (silent == Silent::kEverything) continue;
      if (silent == Silent::kGyro || silent == Silent::kGyroAndCompass) tick.gyro_rad_s.reset();
      if (silent == Silent::kCompass || silent == Silent::kGyroAndCompass) tick.compass_rad.reset();
      if (silent == Silent::kAttitude) tick.roll_pitch_rad.reset();
      if (silent == Silent::kDepth) tick.depth_m.reset();
      if (silent == Silent::kAltitude) tick.altitude_m.reset();
    }
    ticks.push_back(std::move(tick));
  }
  survey.ticks = std::move(ticks);
  return survey;
}

Outage outage_of(const char* name, Silent silent, int seeds) {
  Outage result;
  double sum = 0.0, dof = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const SimulatedSurvey survey = survey_with(silent, static_cast<std::uint64_t>(seed));
    LevelledBuilderConfig config = matched({});
    split_every(config, 50.0);
    for (const LevelledSubmap& map : build_maps(survey, config)) {
      if (map.end_time_s <= kBegin_s || map.start_time_s >= kEnd_s) continue;
      const Eigen::VectorXd error = map_error(map, survey);
      const double of_map = nees(error, map.covariance, error.size());
      sum += of_map;
      dof += static_cast<double>(error.size());
      result.worst_per_dof = std::max(result.worst_per_dof, of_map / static_cast<double>(error.size()));
      result.position += nees(error, map.covariance, 2);
      ++result.maps;
    }
  }
  result.per_dof = sum / dof;
  result.position /= result.maps;
  std::printf("| %s | %d | %.2f | %.1f | %.2f |\n", name, result.maps, result.per_dof, result.worst_per_dof, result.position);
  return result;
}

TEST(LevelledOutage, A25_NobodyTellsOfTheTurnForTenMinutes) {
  EXPECT_LT(outage_of("everything", Silent::kEverything, 2).per_dof, 1.3);  // 5.5 where P is all there is
  EXPECT_LT(outage_of("gyro and compass", Silent::kGyroAndCompass, 2).per_dof, 1.3);
}

TEST(LevelledOutage, A17_A25_TenMinutesWithoutEachSensorLong) {
  const auto expect_honest = [](const char* name, Silent silent) {
    const Outage outage = outage_of(name, silent, 6);
    EXPECT_LT(outage.per_dof, 1.25) << name;
    EXPECT_LT(outage.position, 2.6) << name;
  };
  expect_honest("nothing", Silent::kNothing);
  expect_honest("velocity log", Silent::kVelocity);
  expect_honest("gyro", Silent::kGyro);
  expect_honest("compass", Silent::kCompass);
  expect_honest("gyro and compass", Silent::kGyroAndCompass);
  expect_honest("roll and pitch", Silent::kAttitude);
  expect_honest("depth", Silent::kDepth);
  expect_honest("altitude", Silent::kAltitude);
  expect_honest("everything", Silent::kEverything);
}

}  // namespace
}  // namespace ssjs
