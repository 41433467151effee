#include "ssjs/survey/bottom_tracking.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/survey/side_scan_geometry.hpp"
#include "survey/survey_pings.hpp"

namespace ssjs {
namespace {

using testing::one_line;
using testing::simulated_survey;

TEST(BottomTrackingTest, SS15_FollowsTheSeabedThroughSpeckleObjectsAndSilentPings) {
  SeabedConfig bottom;
  bottom.undulation_m = 0.4;
  bottom.slope_east = 0.05;
  SideScanSimulationConfig sonar;
  sonar.noise_db = -25;
  auto survey = simulated_survey(bottom, scatter_objects(20, {0, 4}, {80, 20}, 3, 2), one_line(80), sonar, 2);
  std::vector<double> truth_m;
  for (SideScanPing& ping : survey.pings) {
    truth_m.push_back(ping.altitude_m);
    ping.altitude_m = SideScanPing::kUnknown;
  }
  for (int n = 100; n < 110; ++n) {
    for (SideScanChannel& channel : survey.pings[static_cast<std::size_t>(n)].channels)
      channel.samples.assign(channel.samples.size(), 0.0F);
  }
  const std::vector<double> found_m = track_bottom(survey.pings, {});
  double square = 0;
  double worst = 0;
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    const double error = altitude_of_first_return_m(survey.pings[i], found_m[i]) - truth_m[i];
    square += error * error;
    worst = std::max(worst, std::abs(error));
  }
  // The bin is 5 cm, a sample 6 cm; where the seabed rises to a side it is heard before the point straight below.
  EXPECT_LT(std::sqrt(square / static_cast<double>(truth_m.size())), 0.12);
  EXPECT_LT(worst, 0.5);
}

TEST(BottomTrackingTest, SS14_StepOfHandMadePings) {
  std::vector<SideScanPing> pings;
  for (int n = 0; n < 20; ++n) {
    SideScanPing ping;
    ping.sound_speed_m_s = 1500;
    SideScanChannel channel;
    channel.sample_interval_s = 2 * 0.1 / 1500;  // 10 cm
    channel.samples.assign(200, 5.0F);
    std::fill(channel.samples.begin() + 60 + n, channel.samples.end(), 100.0F);  // the bottom sinks by 10 cm a ping
    std::fill_n(channel.samples.begin(), 5, 1000.0F);                            // transmission
    if (n == 7) std::fill_n(channel.samples.begin() + 30, 4, 300.0F);            // a fish
    ping.channels = {channel};
    pings.push_back(ping);
  }
  const std::vector<double> found = track_bottom(pings, {});
  for (int n = 0; n < 20; ++n) EXPECT_NEAR(found[static_cast<std::size_t>(n)], 6.0 + 0.1 * n, 0.11) << n;
  EXPECT_THROW(static_cast<void>(track_bottom({SideScanPing{}}, {})), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
