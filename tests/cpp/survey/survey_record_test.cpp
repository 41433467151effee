#include "ssjs/survey/survey_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "ssjs/base/error.hpp"
#include "survey/survey_pings.hpp"

namespace ssjs {
namespace {

using testing::one_line;
using testing::simulated_survey;
using testing::SimulatedSurvey;

/// What a sink is given, block after block.
struct Kept {
  std::vector<PingReach> reach;
  std::vector<PictureRows> rows;
  std::vector<PictureRows> around;
  std::vector<SideScanContact> contacts;
};

Kept record(const std::vector<SideScanPing>& pings, const SideScanSurveyConfig& config) {
  Kept kept;
  SideScanSurvey survey(config, std::nullopt, [&](const FinishedBlock& finished) {
    const std::vector<PingReach> reach = own_reach(finished);
    kept.reach.insert(kept.reach.end(), reach.begin(), reach.end());
    kept.rows.push_back(own_rows(finished));
    for (const SideScanContact& contact : finished.contacts) {
      kept.around.push_back(rows_around(finished, contact, 40));
      kept.contacts.push_back(contact);
    }
  });
  std::vector<SideScanContact> given;
  const auto add = [&](const std::vector<SideScanContact>& more) { given.insert(given.end(), more.begin(), more.end()); };
  for (const SideScanPing& ping : pings) add(survey.feed(ping));
  add(survey.finish());
  EXPECT_EQ(given.size(), kept.contacts.size());
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_EQ(given[i].index, kept.contacts.at(i).index);
  return kept;
}

SimulatedSurvey some_survey() { return simulated_survey({}, scatter_objects(30, {5, -26}, {145, 26}, 6, 11), one_line(150), {}, 11); }

TEST(SurveyRecordTest, EveryPingIsGivenOnceAndInOrder) {
  const SimulatedSurvey survey = some_survey();
  const Kept kept = record(survey.pings, {});
  ASSERT_EQ(kept.reach.size(), survey.pings.size());
  for (std::size_t i = 0; i < kept.reach.size(); ++i) {
    EXPECT_EQ(kept.reach[i].time_s, survey.pings[i].time_s);
    EXPECT_EQ(kept.reach[i].altitude_m, survey.pings[i].altitude_m);
  }
  std::uint64_t next = 0;
  for (const PictureRows& rows : kept.rows) {
    EXPECT_EQ(rows.first_index, next);
    next += static_cast<std::uint64_t>(rows.grey.rows);
  }
  EXPECT_EQ(next, survey.pings.size());
}

TEST(SurveyRecordTest, TheReachRunsFromTheNadirToWhereTheSlantRangeMeetsTheSeabed) {
  const SimulatedSurvey survey = some_survey();
  const SideScanSurveyConfig config;
  for (const PingReach& ping : record(survey.pings, config).reach) {
    const double farthest_m = std::sqrt(30.0 * 30.0 - ping.altitude_m * ping.altitude_m);  // samples end at 30 m
    for (const std::size_t side : {0U, 2U}) {
      EXPECT_NEAR(ping.reach_m.at(side), config.least_ground_range_m, config.column_m);
      EXPECT_NEAR(ping.reach_m.at(side + 1), farthest_m, 0.3);
    }
  }
}

TEST(SurveyRecordTest, ATurnIsNotListenedTo) {
  SimulatedSurvey survey = some_survey();
  for (std::size_t i = 300; i < 330; ++i) survey.pings[i].heading_rad += 0.1 * static_cast<double>(i - 300);
  const Kept kept = record(survey.pings, {});
  EXPECT_TRUE(std::isnan(kept.reach[315].reach_m[0]));
  EXPECT_TRUE(std::isnan(kept.reach[315].reach_m[3]));
  EXPECT_FALSE(std::isnan(kept.reach[200].reach_m[0]));
}

TEST(SurveyRecordTest, ThePictureAroundAContactHoldsItsEchoAndItsShadow) {
  const SimulatedSurvey survey = some_survey();
  const Kept kept = record(survey.pings, {});
  ASSERT_GE(kept.contacts.size(), 10U);
  for (std::size_t i = 0; i < kept.contacts.size(); ++i) {
    const SideScanContact& contact = kept.contacts[i];
    const PictureRows& picture = kept.around[i];
    const int row = static_cast<int>(contact.index - picture.first_index);
    const int before = std::min(static_cast<int>(contact.index), 40);  // blocks overlap by as many; the survey's ends have fewer
    const int after = std::min(static_cast<int>(survey.pings.size() - 1 - contact.index), 40);
    EXPECT_EQ(row, before);
    EXPECT_EQ(picture.grey.rows, before + 1 + after);
    // the brightest pixel on the ground where the echo lies is far above the seabed, which is normalised to 64
    const double across = contact.side == SonarSide::kStarboard ? contact.ground_range_m : -contact.ground_range_m;
    const int column = picture.nadir_column + static_cast<int>(std::floor(across / picture.column_m));
    const int half = static_cast<int>(std::ceil(0.5 * contact.width_m / picture.column_m)) + 3;
    const cv::Rect echo = cv::Rect(column - half, row - 2, 2 * half + 1, 5) & cv::Rect(0, 0, picture.grey.cols, picture.grey.rows);
    double brightest = 0;
    cv::minMaxLoc(picture.grey(echo), nullptr, &brightest);
    EXPECT_GT(brightest, 2 * 64.0);
  }
}

TEST(SurveyRecordTest, APingOfAnotherBlockIsRefused) {
  bool called = false;
  SideScanSurvey survey({}, std::nullopt, [&](const FinishedBlock& finished) {
    called = true;
    SideScanContact elsewhere;
    elsewhere.index = finished.first_index + 5000;
    EXPECT_THROW(static_cast<void>(rows_around(finished, elsewhere, 40)), InvalidArgument);
  });
  for (const SideScanPing& ping : some_survey().pings) static_cast<void>(survey.feed(ping));
  static_cast<void>(survey.finish());
  EXPECT_TRUE(called);
}

}  // namespace
}  // namespace ssjs
