/// What hours of a survey that covers the same ground again and again cost and hold. docs/math/ports.md, "How it grows".
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <deque>

#include "mapping/survey_run.hpp"
#include "ssjs/pipeline/levelled_pipeline.hpp"

namespace ssjs {
namespace {

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::size_t bytes_of(const std::deque<PortMap>& maps) {
  std::size_t numbers = 0;
  std::size_t bytes = 0;
  for (const PortMap& map : maps) {
    numbers += static_cast<std::size_t>(map.submap.mean.size() + map.submap.covariance.size());
    for (const LevelledStep& step : map.submap.steps) numbers += static_cast<std::size_t>(step.gain.size());
    bytes += sizeof(PortMap) + sizeof(LevelledStep) * map.submap.steps.size();
  }
  return bytes + sizeof(double) * numbers;
}

TEST(LevelledGrowth, MemoryOfAFourHourLawnMowerGrowsWithItsStepsAloneLong) {
  SurveyWorldConfig world;
  world.lines = 40;
  world.line_length_m = 400.0;
  world.line_spacing_m = 7.5;
  world.cross_lines = 10;
  world.landmarks = 100;
  const SimulatedSurvey survey = simulate_survey(survey_world(world, 1), {}, 1);
  LevelledConfig config;
  config.local = testing::matched({});
  config.local.association.method = AssociationMethod::kJointCompatibility;
  LevelledPipeline pipeline(config);
  double local_s = 0.0, closing_s = 0.0, slowest_s = 0.0;
  std::size_t steps = 0;
  for (const NavigationTick& tick : survey.ticks) {
    const double begin = cpu_s();
    const LevelledReport report = pipeline.feed(tick);
    const double took_s = cpu_s() - begin;
    steps += report.remembered ? 1U : 0U;
    (report.join ? closing_s : local_s) += took_s;
    if (report.join) slowest_s = std::max(slowest_s, took_s);
  }
  const double begin = cpu_s();
  static_cast<void>(pipeline.finish());
  const double hours = survey.ticks.back().time_s / 3600.0;
  const double megabytes = static_cast<double>(bytes_of(pipeline.maps())) / 1e6;
  std::printf("%.2f h, %zu maps: local %.1f s, closings %.1f s (slowest %.0f ms), end %.2f s; maps hold %.1f MB in %zu steps\n", hours,
              pipeline.maps().size(), local_s, closing_s, 1e3 * slowest_s, cpu_s() - begin, megabytes, steps);
  EXPECT_GT(pipeline.maps().size(), 150U);
  EXPECT_LT(megabytes, 5.0 * hours);
}

}  // namespace
}  // namespace ssjs
