/// What a checkpoint of hours costs, and how it grows. docs/embedding.md, "State survives".
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>

#include "base/temporary_folder.hpp"
#include "ssjs/pipeline/online_survey.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {
namespace {

/// Of this thread alone: what writes in the background is not the caller's.
double thread_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

TEST(CheckpointGrowth, AFileGrowsWithTheSurveyAloneLong) {
  SurveyWorldConfig world;
  world.lines = 40;
  world.line_length_m = 400.0;
  world.line_spacing_m = 7.5;
  world.cross_lines = 10;
  world.landmarks = 100;
  const SimulatedSurvey simulated = simulate_survey(survey_world(world, 1), {}, 1);
  const TemporaryFolder folder;
  const std::string path = folder / "state";
  OnlineSurvey survey({});
  double next_s = 60.0, next_print_s = 1800.0, slowest_ms = 0.0;
  for (const NavigationTick& tick : simulated.ticks) {
    survey.feed(tick);
    if (tick.time_s < next_s) continue;
    next_s += 60.0;
    survey.wait_for_checkpoint();
    const double begin = thread_ms();
    ASSERT_TRUE(survey.checkpoint(path));
    slowest_ms = std::max(slowest_ms, thread_ms() - begin);
    if (tick.time_s < next_print_s) continue;
    next_print_s += 1800.0;
    const double write_begin = thread_ms();
    const std::string bytes = survey.checkpoint();
    const double written = thread_ms();
    static_cast<void>(OnlineSurvey::restored({}, bytes, "state"));
    std::printf("%4.1f h, %3d maps: the caller waits %.2f ms at most; whole %.2f MB, made in %.0f ms, restored in %.0f ms (CPU)\n",
                tick.time_s / 3600.0, survey.status().submaps, slowest_ms, static_cast<double>(bytes.size()) / 1e6, written - write_begin,
                thread_ms() - written);
    slowest_ms = 0.0;
  }
  survey.wait_for_checkpoint();
  EXPECT_LT(static_cast<double>(std::filesystem::file_size(path)) / 1e6, 6.0 * simulated.ticks.back().time_s / 3600.0);
}

}  // namespace
}  // namespace ssjs
