#include "ssjs/simulation/side_scan_mission.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace ssjs {
namespace {

TEST(SideScanMission, TheSonarIsOffWhereTheVehicleIsHigh) {
  SideScanMissionConfig config;
  config.lines.lines = 1;
  config.lines.line_length_m = 150.0;
  config.lines.cross_lines = 0;
  config.lines.dives = 2;
  config.vehicle.depth_gain_rad_m = 0.3;
  config.ping_interval_s = 0.5;
  config.max_altitude_m = 8.0;
  config.objects = 5;
  SideScanMission mission(config, 3);
  double last_s = -config.ping_interval_s;
  double longest_gap_s = 0.0;
  std::uint32_t count = 0;
  while (const std::optional<SideScanPing> ping = mission.next_ping()) {
    EXPECT_EQ(ping->number, count++);
    if (!std::isnan(ping->altitude_m)) {
      EXPECT_LE(ping->altitude_m, 8.0);
    }
    longest_gap_s = std::max(longest_gap_s, ping->time_s - last_s);
    last_s = ping->time_s;
  }
  // 150 m back and 60 m farther at 1.5 m/s, less the climb from 4 m to 8 m above the bottom and back at a quarter of the speed
  EXPECT_GT(longest_gap_s, 80.0);
  EXPECT_GT(count, 200U);
}

}  // namespace
}  // namespace ssjs
