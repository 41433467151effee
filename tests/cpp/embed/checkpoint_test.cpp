#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <random>

#include "base/temporary_folder.hpp"
#include "embed/checkpointed.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/whole_file.hpp"
#include "ssjs/pipeline/checkpoint_file.hpp"

namespace ssjs {
namespace {

using testing::configured;
using testing::said_by;
using testing::Settings;
using testing::small_survey;
using testing::unruly;

struct Kind {
  const char* name;
  Settings settings;
  bool with_fixes = false;
  friend std::ostream& operator<<(std::ostream& out, const Kind& kind) { return out << kind.name; }
};

/// Between them they use every member of the state.
std::vector<Kind> kinds() {
  const std::pair<std::string, std::string> short_maps{"split.longest_m", "60"};
  return {
      {"Batch", {short_maps}},
      {"Recursive", {short_maps, {"joining.solver", "recursive"}}},
      {"KnownNorthDrifting",
       {short_maps, {"association.method", "known"}, {"joining.north_offset_rad", "0.7"}, {"motion.compass_walk_rad_sqrt_s", "0.001"}}},
      {"RecursiveNorthMean",
       {short_maps,
        {"joining.solver", "recursive"},
        {"joining.north_offset_rad", "0.7"},
        {"compass_use", "mean"},
        {"joining.offset_drift_rad_per_sqrt_s", "0.001"}}},
      {"RatesCalibratedEveryPose",
       {short_maps,
        {"motion.drive", "rates"},
        {"start.log_scale_sigma", "0.01"},
        {"trajectory_interval_s", "0"},
        {"arrival.window_s", "2"},
        {"joining_delay_s", "20"}}},
      {"NoMemoryOfPoses", {short_maps, {"condition_trajectory", "false"}, {"compass_use", "first_reading"}}},
      {"Fixes", {short_maps}, true},
      {"RecursiveFixes", {short_maps, {"joining.solver", "recursive"}}, true},
  };
}

class Checkpoint : public ::testing::TestWithParam<Kind> {
 protected:
  [[nodiscard]] std::unique_ptr<OnlineSurvey> restored(OnlineSurvey& survey) const {
    return OnlineSurvey::restored(config, survey.checkpoint(), "state");
  }
  [[nodiscard]] std::string end_of(OnlineSurvey& survey, std::size_t from) const {
    for (std::size_t i = from; i < ticks.size(); ++i) survey.feed(ticks[i]);
    survey.finish();
    return said_by(survey);
  }

  OnlineSurveyConfig config = configured(GetParam().settings);
  std::vector<NavigationTick> ticks = unruly(small_survey(5, GetParam().with_fixes), 7);
};

TEST_P(Checkpoint, AtRandomMomentsItGoesOnToTheSameBytes) {
  OnlineSurvey whole(config);
  std::mt19937_64 random(11);
  auto survey = std::make_unique<OnlineSurvey>(config);
  std::size_t next = 0;
  int times = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    whole.feed(ticks[i]);
    survey->feed(ticks[i]);
    if (i < next) continue;
    next = i + 1 + random() % 120U;
    const std::string state = survey->checkpoint();
    ASSERT_TRUE(state == whole.checkpoint()) << "tick " << i;
    survey = OnlineSurvey::restored(config, state, "state");
    ASSERT_TRUE(survey->checkpoint() == state) << "tick " << i;
    ++times;
  }
  EXPECT_GT(times, 30);
  whole.finish();
  survey->finish();
  EXPECT_GE(whole.status().submaps, 5);
  EXPECT_EQ(said_by(*survey), said_by(whole));
}

TEST_P(Checkpoint, AtEveryStage) {
  OnlineSurvey whole(config);
  const std::string end = end_of(whole, 0);
  EXPECT_EQ(said_by(*restored(whole)), end);  // after finish()

  OnlineSurvey survey(config);
  EXPECT_EQ(end_of(*restored(survey), 0), end);  // empty
  survey.feed(ticks[0]);
  EXPECT_EQ(end_of(*restored(survey), 1), end);  // the first sample, which waits
  bool in_a_submap = false, joining = false, joined = false;
  std::size_t closed_at = 0;
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    const int submaps = survey.status().submaps;
    survey.feed(ticks[i]);
    const SurveyStatus status = survey.status();
    if (status.submaps > submaps) closed_at = i;
    if (!in_a_submap && submaps == 0 && status.landmarks > 2) {
      in_a_submap = true;
      EXPECT_EQ(end_of(*restored(survey), i + 1), end);
    } else if (!joining && status.submaps == 3) {  // just closed: what its join finds is taken over later
      joining = true;
      EXPECT_EQ(end_of(*restored(survey), i + 1), end);
    } else if (!joined && status.submaps >= 4 && i == closed_at + 120) {  // 12 s later: taken over, where that takes 5 s
      joined = true;
      EXPECT_EQ(end_of(*restored(survey), i + 1), end);
    }
  }
  EXPECT_TRUE(in_a_submap && joining && joined);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Checkpoint, ::testing::ValuesIn(kinds()),
                         [](const ::testing::TestParamInfo<Kind>& kind) { return kind.param.name; });

/// A survey in its third submap.
class CheckpointFile : public ::testing::Test {
 protected:
  CheckpointFile() : survey(config) {
    const std::vector<NavigationTick> ticks = small_survey(3);
    for (const NavigationTick& tick : ticks) {
      survey.feed(tick);
      if (survey.status().submaps == 2 && !survey.status().joining) break;
    }
    bytes = survey.checkpoint();
  }
  [[nodiscard]] static std::string complaint(const std::function<void()>& action) {
    try {
      action();
    } catch (const FileError& problem) {
      return problem.what();
    }
    return "";
  }
  [[nodiscard]] std::string complaint_about(const std::string& state) const {
    return complaint([&] { static_cast<void>(OnlineSurvey::restored(config, state, "a.state")); });
  }

  OnlineSurveyConfig config = configured({{"split.longest_m", "40"}});
  OnlineSurvey survey;
  std::string bytes;
};

TEST_F(CheckpointFile, IsWrittenInTheBackgroundAndIsOfTheMomentItWasAskedFor) {
  const TemporaryFolder folder;
  const std::string path = folder / "vehicle.state";
  ASSERT_TRUE(survey.checkpoint(path));
  const double now_s = survey.global_T_vehicle()->time_s;
  for (int i = 1; i < 50; ++i) survey.feed(tick_at(now_s + 0.1 * i));
  survey.wait_for_checkpoint();
  EXPECT_TRUE(read_whole_file(path, 1 << 30) == bytes);
  EXPECT_EQ(OnlineSurvey::restored_from(config, path)->global_T_vehicle()->time_s, now_s);
  ASSERT_TRUE(survey.checkpoint(folder / "no such folder/vehicle.state"));
  EXPECT_NE(complaint([&] { survey.wait_for_checkpoint(); }).find("no such folder/vehicle.state.part: cannot be written"),
            std::string::npos);
  EXPECT_NE(complaint([&] { static_cast<void>(OnlineSurvey::restored_from(config, folder / "nothing")); }).find("nothing: is no file"),
            std::string::npos);
}

TEST_F(CheckpointFile, IsRefusedWhereverItIsCutOff) {
  for (std::size_t size = 0; size < bytes.size(); size += size < 6000 ? 1 : 997) {
    const std::string problem = complaint_about(bytes.substr(0, size));
    ASSERT_TRUE(problem.find("cut off") != std::string::npos || size < 7) << size << problem;
    ASSERT_EQ(problem.rfind("a.state: ", 0), 0U) << size << problem;
  }
  EXPECT_NE(complaint_about(bytes + "x").find("bytes after its end"), std::string::npos);
}

TEST_F(CheckpointFile, IsRefusedWhereverAByteIsDamaged) {
  std::string damaged = bytes;
  const std::size_t step = 1 + bytes.size() / 4000;
  for (std::size_t at = 0; at < bytes.size(); at += at < 6000 || at + 100 > bytes.size() ? 1 : step) {
    damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
    ASSERT_EQ(complaint_about(damaged).rfind("a.state: is ", 0), 0U) << at << complaint_about(damaged);
    damaged[at] = bytes[at];
  }
}

/// What a forger could do, or a fault of the writer: whatever the state holds, it is read or refused.
TEST_F(CheckpointFile, AWrongStateUnderARightChecksumIsReadOrRefused) {
  const CheckpointOwner owner{"online survey", field_texts(config)};
  const std::string state(open_checkpoint(owner, bytes, "a.state"));
  std::mt19937_64 random(13);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string wrong = state;
    for (std::uint64_t k = 0; k <= random() % 4U; ++k) wrong[random() % wrong.size()] = static_cast<char>(random());
    if (i % 10 == 0) wrong.resize(random() % wrong.size());
    if (complaint_about(seal_checkpoint(owner, wrong, "")).empty()) continue;
    ++refused;
  }
  EXPECT_GT(refused, 500);
}

TEST_F(CheckpointFile, OfAnotherConfigurationNamesTheKeyThatDiffers) {
  config.slam.joining.max_chance_odds = 0.25;
  EXPECT_EQ(complaint_about(bytes), "a.state: was made with another configuration: joining.max_chance_odds = 0.3, here it is 0.25");
}

}  // namespace
}  // namespace ssjs
