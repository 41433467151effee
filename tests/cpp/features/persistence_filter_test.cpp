#include "ssjs/features/persistence_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ssjs {
namespace {

Feature seen_from(const Se2& world_T_vehicle, const Eigen::Vector2d& world_p_point) {
  const Eigen::Vector2d p = world_T_vehicle.inverse() * world_p_point;
  return {{p.norm(), std::atan2(p.y(), p.x())}, Eigen::Matrix2d::Identity(), std::nullopt};
}

PersistenceConfig one_of_two() {
  PersistenceConfig config;
  config.min_earlier_sightings = 1;
  config.window_scans = 2;
  config.gate_m = 0.5;
  config.gate_growth_m = 0.2;
  return config;
}

TEST(PersistenceFilter, OffHandsEverythingOn) {
  PersistenceFilter filter({});
  EXPECT_EQ(filter.confirmed({seen_from({}, {5.0, 1.0})}, {}).size(), 1U);
}

TEST(PersistenceFilter, F4_WhatStandsStillIsConfirmedWhateverTheVehicleDoes) {
  PersistenceFilter filter(one_of_two());
  const Eigen::Vector2d pile(12.0, 3.0);
  const Se2 first{0.0, 0.0, 0.2};
  const Se2 second{1.5, 0.4, -0.6};
  EXPECT_TRUE(filter.confirmed({seen_from(first, pile)}, first).empty());  // nothing before it
  const Features kept = filter.confirmed({seen_from(second, pile), seen_from(second, {9.0, -4.0})}, second);
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_NEAR(kept[0].range(), (second.inverse() * pile).norm(), 1e-12);
}

TEST(PersistenceFilter, F4_WhatMovesWithTheVehicleIsNot) {
  PersistenceFilter filter(one_of_two());
  const Feature glint{{10.0, 0.0}, Eigen::Matrix2d::Identity(), std::nullopt};  // always right ahead
  for (int scan = 0; scan < 5; ++scan) EXPECT_TRUE(filter.confirmed({glint}, {1.0 * scan, 0.0, 0.0}).empty()) << scan;
}

TEST(PersistenceFilter, F4_TheGateGrowsAndTheWindowEnds) {
  const Eigen::Vector2d pile(10.0, 0.0);
  const auto after_empty_scans = [&](int scans, double offset) {
    PersistenceFilter filter(one_of_two());
    (void)filter.confirmed({seen_from({}, pile)}, {});
    for (int i = 0; i < scans; ++i) (void)filter.confirmed({}, {});
    return filter.confirmed({seen_from({}, pile + Eigen::Vector2d(0.0, offset))}, {}).size();
  };
  EXPECT_EQ(after_empty_scans(0, 0.45), 1U);
  EXPECT_EQ(after_empty_scans(0, 0.6), 0U);  // beyond 0.5 m
  EXPECT_EQ(after_empty_scans(1, 0.6), 1U);  // within 0.7 m
  EXPECT_EQ(after_empty_scans(2, 0.0), 0U);  // forgotten
}

TEST(PersistenceFilter, F4_SightingsOfOneScanCountOnce) {
  PersistenceConfig config = one_of_two();
  config.min_earlier_sightings = 2;
  PersistenceFilter filter(config);
  const Feature here = seen_from({}, {10.0, 0.0});
  EXPECT_TRUE(filter.confirmed({here, here}, {}).empty());
  EXPECT_TRUE(filter.confirmed({here}, {}).empty());  // two sightings, but of one scan
  EXPECT_EQ(filter.confirmed({here}, {}).size(), 1U);
}

}  // namespace
}  // namespace ssjs
