#include "ssjs/survey/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/survey/object_centre.hpp"

namespace ssjs {
namespace {

/// 21 pings 0.2 m apart over flat ground 5 m below, 10 cm columns to 30 m: grey 64, the drawn echo 200 and its shadow 5.
struct Drawn {
  std::vector<SideScanPing> pings;
  Waterfall waterfall;
  cv::Mat grey;

  Drawn() {
    for (int n = 0; n < 21; ++n) {
      SideScanPing ping;
      ping.number = static_cast<std::uint32_t>(100 + n);
      ping.time_s = 0.1 * n;
      ping.speed_m_s = 2;
      ping.altitude_m = 5;
      ping.sound_speed_m_s = 1500;
      ping.pitch_rad = 0;
      SideScanChannel port;
      port.sample_interval_s = 2 * 0.05 / 1500;
      SideScanChannel starboard = port;
      starboard.side = SonarSide::kStarboard;
      ping.channels = {port, starboard};
      pings.push_back(ping);
    }
    waterfall.nadir_column = 300;
    waterfall.column_m = 0.1;
    waterfall.echo = cv::Mat::zeros(21, 600, CV_32F);
    waterfall.valid = cv::Mat(21, 600, CV_8U, cv::Scalar(255));
    grey = cv::Mat(21, 600, CV_8U, cv::Scalar(64));
  }
  void draw(SonarSide side, int first_row, int rows, double from_m, double to_m, int level) {
    const int near = static_cast<int>(std::lround(from_m / 0.1));
    const int far = static_cast<int>(std::lround(to_m / 0.1));
    const int x = side == SonarSide::kStarboard ? 300 + near : 300 - far;
    grey(cv::Rect(x, first_row, far - near, rows)).setTo(level);
  }
  [[nodiscard]] ContactBox box(SonarSide side, int first_row, int rows, double from_m, double to_m) const {
    const int near = static_cast<int>(std::lround(from_m / 0.1));
    const int far = static_cast<int>(std::lround(to_m / 0.1));
    return {side, {side == SonarSide::kStarboard ? 300 + near : 300 - far, first_row, far - near, rows}};
  }
  [[nodiscard]] ContactPicture picture() const { return {pings, waterfall, grey, 1000}; }
};

TEST(ContactTest, SS17_HeightOfADrawnShadow) {
  // A box 1 m high whose far upper edge stands at 16 m: heard at sqrt(16^2 + 4^2), drawn where flat ground is heard then; tip at 20 m.
  const double start_m = std::sqrt(16.0 * 16 + 4 * 4 - 5 * 5);
  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    Drawn drawn;
    drawn.draw(side, 8, 6, 14.5, start_m, 200);
    drawn.draw(side, 8, 6, start_m, 20.0, 5);
    const auto contact = measure_contact(drawn.picture(), drawn.box(side, 8, 6, 14.5, start_m), {}, {});
    ASSERT_TRUE(contact);
    EXPECT_NEAR(*contact->height_m, 1.0, 0.03);  // a column is 10 cm: 5 m * 0.1 / 20 for each edge
    EXPECT_NEAR(contact->shadow_m, 20.0 - start_m, 0.1);
    EXPECT_FALSE(contact->shadow_is_cut);
    // (SS-33) rows 8 .. 13: their middle lies half-way between two pings, 0.2 m apart; the later one is abeam and the object behind it
    EXPECT_EQ(contact->ping, 111U);
    EXPECT_EQ(contact->index, 1011U);
    EXPECT_NEAR(contact->body_p_contact.position_m.x(), -0.1, 1e-9);
    EXPECT_EQ(contact->side, side);
    // (SS-18) between the echo's first column and the last before the shadow
    const auto slant = [](double ground_m) { return std::hypot(ground_m, 5.0); };
    EXPECT_NEAR(contact->ground_range_m, centre_of_object({5, slant(14.5), slant(start_m), slant(20)}).ground_range_m, 0.05);
    EXPECT_NEAR(contact->body_p_contact.position_m.y(), starboard_sign(side) * contact->ground_range_m, 1e-9);
    EXPECT_NEAR(contact->body_p_contact.position_m.z(), 5, 1e-9);
    EXPECT_NEAR(contact->sample, contact->slant_range_m / 0.05, 1e-6);
    EXPECT_NEAR(contact->length_m, 6 * 0.2 - 0.007 * contact->slant_range_m, 1e-9);
    EXPECT_GT(contact->confidence, 0.7);
    EXPECT_GT(contact->body_p_contact.covariance_m2.diagonal().minCoeff(), 0);
  }
}

TEST(ContactTest, SS33_AnObjectAskewIsMeasuredInItsOwnDirection) {
  // Each row lies 0.2 m farther out than the one before: in every row 1 m of echo and 3 m of shadow.
  Drawn drawn;
  for (int row = 0; row < 7; ++row) {
    const double near_m = 14 + 0.2 * row;
    drawn.draw(SonarSide::kStarboard, 7 + row, 1, near_m, near_m + 1, 200);
    drawn.draw(SonarSide::kStarboard, 7 + row, 1, near_m + 1, near_m + 4, 5);
  }
  const auto contact = measure_contact(drawn.picture(), drawn.box(SonarSide::kStarboard, 7, 7, 14, 16.2), {}, {});
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->index, 1010U);  // the middle row, whose echo begins at 14.6 m
  EXPECT_NEAR(contact->body_p_contact.position_m.x(), 0, 1e-9);
  EXPECT_NEAR(contact->shadow_m, 3.0, 0.1);
  const auto slant = [](double ground_m) { return std::hypot(ground_m, 5.0); };
  EXPECT_NEAR(contact->ground_range_m, centre_of_object({5, slant(14.6), slant(15.6), slant(18.6)}).ground_range_m, 0.05);
}

TEST(ContactTest, ADarkColumnInTheEchoDoesNotEndIt) {
  Drawn drawn;
  drawn.draw(SonarSide::kPort, 8, 5, 14, 15.5, 160);
  drawn.draw(SonarSide::kPort, 8, 5, 14.5, 14.6, 60);
  drawn.draw(SonarSide::kPort, 8, 5, 15.5, 19, 5);
  const auto whole = measure_contact(drawn.picture(), drawn.box(SonarSide::kPort, 8, 5, 14, 15.5), {}, {});
  ASSERT_TRUE(whole);
  const auto slant = [](double ground_m) { return std::hypot(ground_m, 5.0); };
  EXPECT_NEAR(whole->ground_range_m, centre_of_object({5, slant(14), slant(15.5), slant(19)}).ground_range_m, 0.05);
}

TEST(ContactTest, NoShadowNoContactAndACutShadowSaysSo) {
  Drawn drawn;
  drawn.draw(SonarSide::kPort, 8, 6, 14, 15, 200);
  EXPECT_FALSE(measure_contact(drawn.picture(), drawn.box(SonarSide::kPort, 8, 6, 14, 15), {}, {}));
  drawn.draw(SonarSide::kPort, 8, 6, 15, 30, 5);
  const auto cut = measure_contact(drawn.picture(), drawn.box(SonarSide::kPort, 8, 6, 14, 15), {}, {});
  ASSERT_TRUE(cut);
  EXPECT_TRUE(cut->shadow_is_cut);
  EXPECT_NEAR(cut->shadow_m, 15, 0.1);
  for (SideScanPing& ping : drawn.pings) ping.altitude_m = SideScanPing::kUnknown;
  EXPECT_FALSE(measure_contact(drawn.picture(), drawn.box(SonarSide::kPort, 8, 6, 14, 15), {}, {}));
  EXPECT_THROW(static_cast<void>(measure_contact(drawn.picture(), {SonarSide::kPort, {700, 0, 5, 5}}, {}, {})), InvalidArgument);
}

/// A piece in the rows [first, first + 4), columns of 0.1 m, rows of 0.2 m.
SideScanContact piece_at(int first, cv::Range columns, double confidence) {
  SideScanContact piece;
  piece.side = SonarSide::kPort;
  piece.box = cv::Rect(columns.start, first, columns.size(), 4);
  piece.row_m = 0.2;
  piece.column_m = 0.1;
  piece.length_m = 0.8;
  piece.first_index = static_cast<std::uint64_t>(first);
  piece.last_index = piece.first_index + 3;
  piece.index = piece.first_index + 2;
  piece.confidence = confidence;
  return piece;
}

TEST(ContactTest, PiecesOfOneObjectBecomeOneAndNeighboursStayTwo) {
  const SideScanContact piece = piece_at(10, {115, 125}, 0.7);
  const SideScanContact next = piece_at(16, {120, 130}, 0.8);  // 0.6 m further along
  SideScanContact other_side = piece;
  other_side.side = SonarSide::kStarboard;
  const SideScanContact far = piece_at(10, {195, 205}, 0.7);
  const std::vector<SideScanContact> merged = merge_contacts({next, far, piece, other_side}, 1.0);
  ASSERT_EQ(merged.size(), 3U);
  int pieces = 0;
  for (const SideScanContact& contact : merged) {
    pieces += contact.pieces;
    if (contact.pieces != 2) continue;
    EXPECT_EQ(contact.confidence, 0.8);
    EXPECT_EQ(contact.first_index, 10U);
    EXPECT_EQ(contact.last_index, 19U);
    EXPECT_NEAR(contact.length_m, 10 * 0.2, 1e-12);
    EXPECT_EQ(contact.box, cv::Rect(115, 10, 15, 10));
  }
  EXPECT_EQ(pieces, 4);
  EXPECT_EQ(merge_contacts({next, piece}, 0.3).size(), 2U);
}

TEST(ContactTest, WhatALaterPieceTiesTogetherIsOne) {
  const SideScanContact near = piece_at(10, {100, 110}, 0.7);
  const SideScanContact far = piece_at(12, {160, 170}, 0.7);  // 5 m from the other
  const SideScanContact between = piece_at(15, {105, 165}, 0.7);
  ASSERT_EQ(merge_contacts({near, far}, 1.0).size(), 2U);
  const std::vector<SideScanContact> merged = merge_contacts({near, far, between}, 1.0);
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].pieces, 3);
}

/// Two objects with a shadow each in the rows 2 .. 5 and 15 .. 18, as merge_contacts() would hand them on: in one box of 17 rows, 3.4 m.
SideScanContact two_objects(Drawn& drawn) {
  for (const int row : {2, 15}) {
    drawn.draw(SonarSide::kStarboard, row, 4, 14, 15, 200);
    drawn.draw(SonarSide::kStarboard, row, 4, 15, 17, 5);
  }
  const auto first = measure_contact(drawn.picture(), drawn.box(SonarSide::kStarboard, 2, 4, 14, 15), {}, {});
  const auto last = measure_contact(drawn.picture(), drawn.box(SonarSide::kStarboard, 15, 4, 14, 15), {}, {});
  EXPECT_TRUE(first && last);
  return merge_contacts({*first, *last}, 2.0).at(0);
}

TEST(ContactTest, SS36_AStructureLiesAnywhereInTheBoxOfItsPieces) {
  Drawn drawn;
  const SideScanContact pieces = two_objects(drawn);
  ASSERT_EQ(pieces.pieces, 2);
  ContactConfig config;
  config.structure_m = 2.0;
  const SideScanContact whole = measure_whole(drawn.picture(), pieces, config, {});
  EXPECT_EQ(whole.pieces, 2);
  EXPECT_EQ(whole.ping, 110U);  // rows 2 .. 18
  EXPECT_NEAR(whole.length_m, 17 * 0.2, 0.5);
  EXPECT_NEAR(whole.width_m, 1.0, 1e-9);
  EXPECT_NEAR(whole.ground_range_m, 14.5, 1e-9);
  EXPECT_NEAR(whole.body_p_contact.position_m.y(), 14.5, 1e-6);
  EXPECT_NEAR(whole.body_p_contact.covariance_m2(0, 0), std::pow(17 * 0.2, 2) / 12.0, 0.15);
  EXPECT_GT(whole.body_p_contact.covariance_m2(1, 1), 1.0 / 12.0);
}

TEST(ContactTest, SS36_APieceInABoxOfNoiseIsNoStructure) {
  Drawn drawn;
  SideScanContact pieces = two_objects(drawn);
  ContactConfig config;
  config.structure_m = 2.0;
  pieces.traced_m = 0.2 * pieces.length_m;  // the pieces fill a fifth of it
  const SideScanContact whole = measure_whole(drawn.picture(), pieces, config, {});
  EXPECT_LT(whole.length_m, 1.2);
  pieces.traced_m = pieces.length_m;
  config.structure_m = 5.0;  // longer than it is
  EXPECT_LT(measure_whole(drawn.picture(), pieces, config, {}).length_m, 1.2);
}

TEST(ContactTest, RowSpacingFromPositionsOrSpeed) {
  std::vector<SideScanPing> pings(3);
  for (int n = 0; n < 3; ++n) {
    pings[static_cast<std::size_t>(n)].time_s = n;
    pings[static_cast<std::size_t>(n)].speed_m_s = 0.25;
  }
  EXPECT_NEAR(row_spacing_m(pings, 0, 2), 0.25, 1e-12);
  for (int n = 0; n < 3; ++n) {
    pings[static_cast<std::size_t>(n)].east_m = 0.3 * n;
    pings[static_cast<std::size_t>(n)].north_m = 0.4 * n;
  }
  EXPECT_NEAR(row_spacing_m(pings, 0, 2), 0.5, 1e-12);
  std::vector<SideScanPing> fixes(2);
  EXPECT_THROW(static_cast<void>(row_spacing_m(fixes, 0, 1)), InvalidArgument);
  fixes[0].latitude_deg = 60;
  fixes[0].longitude_deg = fixes[1].longitude_deg = 5;
  fixes[1].latitude_deg = 60 + 1e-5;  // a degree is 111.2 km
  EXPECT_NEAR(row_spacing_m(fixes, 0, 1), 1.112, 0.001);
}

}  // namespace
}  // namespace ssjs
