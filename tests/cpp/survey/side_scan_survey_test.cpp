#include "ssjs/survey/side_scan_survey.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "survey/survey_pings.hpp"

namespace ssjs {
namespace {

using testing::one_line;
using testing::simulated_survey;
using testing::SimulatedSurvey;

std::vector<SideScanContact> contacts_of(const std::vector<SideScanPing>& pings, const SideScanSurveyConfig& config) {
  SideScanSurvey survey(config);
  std::vector<SideScanContact> contacts;
  const auto add = [&](const std::vector<SideScanContact>& more) { contacts.insert(contacts.end(), more.begin(), more.end()); };
  for (const SideScanPing& ping : pings) add(survey.feed(ping));
  add(survey.finish());
  return contacts;
}

/// Sightings well inside the swath, and which of them a contact of the same side lies within a metre and a half of.
struct Score {
  int wanted = 0;
  int found = 0;
  std::size_t false_contacts = 0;
  double across_square = 0;
  double height_square = 0;
};

Score score(const SimulatedSurvey& survey, const std::vector<SideScanContact>& contacts) {
  Score score;
  std::vector<bool> used(contacts.size(), false);
  for (const ObjectSighting& sighting : survey.sightings) {
    const double across = std::abs(sighting.body_p_object.y());
    const bool wanted = across > 5 && across < 26;
    double nearest = 1.5;
    std::size_t match = contacts.size();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (contacts[i].side != sighting.side) continue;
      const double along = (static_cast<double>(contacts[i].index) - sighting.ping) * 1.5 / 7;
      const double distance = std::hypot(along, contacts[i].body_p_contact.position_m.y() - sighting.body_p_object.y());
      if (distance < nearest) {
        nearest = distance;
        match = i;
      }
    }
    score.wanted += wanted ? 1 : 0;
    if (match == contacts.size()) continue;
    used[match] = true;
    if (!wanted) continue;
    ++score.found;
    score.across_square += std::pow(contacts[match].body_p_contact.position_m.y() - sighting.body_p_object.y(), 2);
    const double height = survey.seabed.objects()[static_cast<std::size_t>(sighting.object)].height_m;
    if (contacts[match].height_m && !contacts[match].shadow_is_cut) score.height_square += std::pow(*contacts[match].height_m - height, 2);
  }
  score.false_contacts = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  return score;
}

TEST(SideScanSurveyTest, FindsAndMeasuresWhatLiesOnASpeckledSeabed) {
  Score sum;
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const SimulatedSurvey survey = simulated_survey({}, scatter_objects(40, {5, -26}, {145, 26}, 6, seed), one_line(150), {}, seed);
    const Score one = score(survey, contacts_of(survey.pings, {}));
    sum.wanted += one.wanted;
    sum.found += one.found;
    sum.false_contacts += one.false_contacts;
    sum.across_square += one.across_square;
    sum.height_square += one.height_square;
  }
  EXPECT_GE(sum.wanted, 80);
  EXPECT_GE(sum.found, 0.85 * sum.wanted) << sum.found << " of " << sum.wanted;
  EXPECT_LE(static_cast<double>(sum.false_contacts), 0.1 * sum.found);
  EXPECT_LT(std::sqrt(sum.across_square / sum.found), 0.5);
  EXPECT_LT(std::sqrt(sum.height_square / sum.found), 0.25);
  RecordProperty("found", sum.found);
  RecordProperty("wanted", sum.wanted);
}

TEST(SideScanSurveyTest, AnEmptySeabedHasNoContacts) {
  SeabedConfig bottom;
  bottom.ripple_m = 0.05;
  const SimulatedSurvey survey = simulated_survey(bottom, {}, one_line(150), {}, 5);
  EXPECT_LE(contacts_of(survey.pings, {}).size(), 1U);
}

TEST(SideScanSurveyTest, WhereBlocksEndMakesNoDifferenceToWhatIsFound) {
  const SimulatedSurvey survey = simulated_survey({}, scatter_objects(30, {5, -25}, {115, 25}, 6, 3), one_line(120), {}, 3);
  SideScanSurveyConfig config;
  const std::vector<SideScanContact> whole = contacts_of(survey.pings, config);
  config.block_pings = 250;
  const std::vector<SideScanContact> cut = contacts_of(survey.pings, config);
  // Gains are medians of a block, so that a weak contact may come or go; none comes twice.
  EXPECT_NEAR(static_cast<double>(cut.size()), static_cast<double>(whole.size()), 2.0);
  for (std::size_t i = 0; i < cut.size(); ++i) {
    for (std::size_t j = i + 1; j < cut.size(); ++j) {
      const bool near = cut[i].side == cut[j].side && std::abs(cut[i].ground_range_m - cut[j].ground_range_m) < 0.5;
      EXPECT_FALSE(near && cut[j].index - cut[i].index < 3) << cut[i].index;
    }
    EXPECT_TRUE(i == 0 || cut[i - 1].index <= cut[i].index);
  }
  EXPECT_EQ(contacts_of(survey.pings, config).size(), cut.size());
}

TEST(SideScanSurveyTest, TracksTheBottomWhereTheLogHasNoAltitude) {
  SimulatedSurvey survey = simulated_survey({}, scatter_objects(30, {5, -25}, {115, 25}, 6, 4), one_line(120), {}, 4);
  const Score known = score(survey, contacts_of(survey.pings, {}));
  for (SideScanPing& ping : survey.pings) ping.altitude_m = SideScanPing::kUnknown;
  const Score tracked = score(survey, contacts_of(survey.pings, {}));
  EXPECT_GE(tracked.found, known.found - 2);
  EXPECT_LT(std::sqrt(tracked.across_square / tracked.found), 0.5);
  SideScanSurveyConfig config;
  config.altitude = AltitudeSource::kLog;
  EXPECT_TRUE(contacts_of(survey.pings, config).empty());
}

TEST(SideScanSurveyTest, NothingIsLookedForInTurns) {
  SurveyTrackConfig track;
  track.lines = 2;
  track.line_length_m = 40;
  track.line_spacing_m = 20;
  const SimulatedSurvey survey = simulated_survey({}, scatter_objects(40, {0, -20}, {70, 40}, 6, 6), track, {}, 6);
  for (const SideScanContact& contact : contacts_of(survey.pings, {})) {
    const double travelled_m = static_cast<double>(contact.index) / 7 * 1.5;
    EXPECT_FALSE(travelled_m > 41.5 && travelled_m < 40 + kPi * 10 - 1.5) << travelled_m;
  }
}

TEST(SideScanSurveyTest, ABadConfigurationIsRefused) {
  SideScanSurveyConfig config;
  config.overlap_pings = 300;
  EXPECT_THROW(SideScanSurvey{config}, InvalidArgument);
  SideScanSurvey empty({});
  EXPECT_TRUE(empty.finish().empty());
}

}  // namespace
}  // namespace ssjs
