#include "ssjs/survey/waterfall.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// Sound at 1500 m/s and 1 m of slant range from sample to sample: port 1, 2, 3, ..., starboard 101, 102, ...
SideScanPing counted_ping(int samples) {
  SideScanPing ping;
  ping.sound_speed_m_s = 1500;
  ping.altitude_m = 3;
  ping.pitch_rad = 0;
  for (const SonarSide side : {SonarSide::kPort, SonarSide::kStarboard}) {
    SideScanChannel channel;
    channel.side = side;
    channel.sample_interval_s = 2.0 / 1500;
    for (int i = 0; i < samples; ++i) channel.samples.push_back(static_cast<float>(side == SonarSide::kPort ? 1 + i : 101 + i));
    ping.channels.push_back(channel);
  }
  return ping;
}

TEST(WaterfallTest, SS10_PortIsLeftStarboardRightAndTheOldestPingOnTop) {
  SideScanPing second = counted_ping(4);
  second.channels[1].samples = {7, 8};  // recording stopped early
  const Waterfall waterfall = slant_waterfall({counted_ping(4), second}, {});
  ASSERT_EQ(waterfall.nadir_column, 4);
  EXPECT_EQ(waterfall.column_m, 1.0);
  // Column k covers k .. k + 1 m and sample i lies at i m: the first of the column.
  const float expected[] = {4, 3, 2, 1, 101, 102, 103, 104};
  for (int c = 0; c < 8; ++c) EXPECT_EQ(waterfall.echo.at<float>(0, c), expected[c]) << c;
  EXPECT_EQ(waterfall.echo.at<float>(1, 5), 8);
  EXPECT_NE(waterfall.valid.at<unsigned char>(1, 5), 0);
  EXPECT_EQ(waterfall.valid.at<unsigned char>(1, 6), 0);
  EXPECT_EQ(waterfall.range_m(3), 0.5);
  EXPECT_EQ(waterfall.range_m(7), 3.5);
  EXPECT_EQ(waterfall.column(SonarSide::kStarboard, 3.5), 7);
  EXPECT_EQ(waterfall.column(SonarSide::kPort, 0.5), 3);
}

TEST(WaterfallTest, SS10_WiderColumnsAverageAndNarrowerOnesRepeat) {
  WaterfallConfig config;
  config.column_m = 2;
  EXPECT_EQ(slant_waterfall({counted_ping(4)}, config).echo.at<float>(0, 2), 101.5F);
  config.column_m = 0.5;
  const Waterfall fine = slant_waterfall({counted_ping(4)}, config);
  EXPECT_EQ(fine.echo.at<float>(0, fine.nadir_column + 4), 103);
  EXPECT_EQ(fine.echo.at<float>(0, fine.nadir_column + 5), 103 + (std::round(2.75) > 2 ? 1 : 0));
}

TEST(WaterfallTest, SS12_GroundRangeIsTheOtherSideOfTheTriangle) {
  WaterfallConfig config;
  config.column_m = 1;
  config.range_m = 9;
  // 3 m up: the sample at slant range 5 m lies 4 m away on the ground, in the column from 4 to 5 m, as no other does (5.83 m comes next).
  const Waterfall level = ground_waterfall({counted_ping(9)}, config);
  EXPECT_EQ(level.echo.at<float>(0, level.nadir_column + 4), 106);
  EXPECT_EQ(level.echo.at<float>(0, level.nadir_column - 1 - 4), 6);
  EXPECT_EQ(level.valid.at<unsigned char>(0, level.nadir_column + 8), 0) << "8 m on the ground are 8.54 m away: not recorded";
  SideScanPing unknown = counted_ping(9);
  unknown.altitude_m = SideScanPing::kUnknown;
  EXPECT_EQ(cv::countNonZero(ground_waterfall({unknown}, config).valid), 0);
  SideScanPing pitched = counted_ping(9);
  pitched.altitude_m = 3 * std::cos(0.4);
  pitched.pitch_rad = 0.4;  // the fan leans and hears the seabed 3 m away
  EXPECT_EQ(cv::countNonZero(ground_waterfall({pitched}, config).echo != level.echo), 0);
}

TEST(WaterfallTest, SS11_TonesRunBetweenPercentiles) {
  WaterfallConfig config;
  const Waterfall waterfall = slant_waterfall({counted_ping(100)}, config);  // 1 .. 200
  ToneConfig tone;
  tone.curve = ToneCurve::kPercentile;
  tone.dark_percent = 0;
  tone.bright_percent = 100 * 100 / 199.0;  // the 101st level
  const SonarImage image = in_grey(waterfall, tone);
  EXPECT_EQ(image.intensity.at<unsigned char>(0, 99), 0);                              // 1
  EXPECT_EQ(image.intensity.at<unsigned char>(0, 199), 255);                           // 200
  EXPECT_EQ(image.intensity.at<unsigned char>(0, 49), std::lround(255 * 50 / 100.0));  // 51 between 1 and 101
  tone.curve = ToneCurve::kLogarithmic;
  EXPECT_EQ(in_grey(waterfall, tone).intensity.at<unsigned char>(0, 49), std::lround(255 * std::log(51.0) / std::log(101.0)));
}

TEST(WaterfallTest, WhatCannotBeAPictureIsRefused) {
  EXPECT_THROW(static_cast<void>(slant_waterfall({}, {})), InvalidArgument);
  WaterfallConfig config;
  config.channel_pair = 1;
  EXPECT_THROW(static_cast<void>(slant_waterfall({counted_ping(4)}, config)), InvalidArgument) << "no second pair";
  SideScanPing silent = counted_ping(4);
  silent.channels[0].sample_interval_s = 0;
  EXPECT_THROW(static_cast<void>(slant_waterfall({silent}, {})), InvalidArgument);
  config = {};
  config.column_m = 1e-6;
  EXPECT_THROW(static_cast<void>(slant_waterfall({counted_ping(4)}, config)), InvalidArgument) << "millions of columns";
}

}  // namespace
}  // namespace ssjs
