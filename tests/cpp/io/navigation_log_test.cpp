#include "ssjs/io/navigation_log.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

Eigen::VectorXd times(std::initializer_list<double> values) {
  Eigen::VectorXd column(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) column(i++) = value;
  return column;
}

TEST(NavigationLog, SamplesOfOneTimeAreOneTick) {
  NavigationLog log;
  log.add_depth(times({0.0, 1.0, 3.0}), times({10.0, 11.0, 12.0}));
  log.add_altitude(times({1.0, 2.0}), times({4.0, 5.0}));
  log.add_attitude(times({1.0}), Eigen::RowVector3d(0.1, 0.2, 0.3));
  log.add_gyro(times({1.0}), Eigen::RowVector3d(0.4, 0.5, 0.6));
  log.add_velocity(times({3.0}), Eigen::RowVector3d(1.5, 0.0, 0.1), {true});
  const std::vector<NavigationTick>& ticks = log.ticks();
  ASSERT_EQ(ticks.size(), 4U);
  EXPECT_EQ(ticks[1].time_s, 1.0);
  EXPECT_EQ(ticks[1].depth_m, 11.0);
  EXPECT_EQ(ticks[1].altitude_m, 4.0);
  EXPECT_EQ(*ticks[1].roll_pitch_rad, Eigen::Vector2d(0.1, 0.2));
  EXPECT_EQ(ticks[1].compass_rad, 0.3);
  EXPECT_EQ(*ticks[1].gyro_rad_s, Eigen::Vector3d(0.4, 0.5, 0.6));
  EXPECT_FALSE(ticks[2].depth_m);
  EXPECT_EQ(ticks[3].velocity->velocity_m_s, Eigen::Vector3d(1.5, 0.0, 0.1));
}

TEST(NavigationLog, SightingsOfOneTimeAreAllKeptWithTheirCovariances) {
  NavigationLog log;
  Eigen::MatrixXd points(2, 3);
  points << 0.0, 10.0, 4.0, 0.1, -8.0, 4.2;
  Eigen::MatrixXd covariance(2, 6);
  covariance << 1.0, 0.1, 0.2, 2.0, 0.3, 3.0, 4.0, 0.0, 0.0, 5.0, 0.0, 6.0;
  log.add_sightings(times({2.0, 2.0}), points, covariance, std::vector<std::int64_t>{7, -1});
  ASSERT_EQ(log.ticks().size(), 1U);
  const SideScanSightings& seen = log.ticks()[0].sightings;
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].landmark_id, 7);
  EXPECT_FALSE(seen[1].landmark_id);
  Eigen::Matrix3d expected;
  expected << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  EXPECT_EQ(*seen[0].covariance, expected);
}

TEST(NavigationLog, FramesHoldTheirOwnSightings) {
  NavigationLog log;
  Eigen::MatrixXd pixel(3, 2);
  pixel << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  Eigen::MatrixXf descriptor(3, 2);
  descriptor << 0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F;
  log.add_frames(times({1.0, 2.0, 3.0}), pixel, {2, 0, 1}, descriptor, std::vector<std::int64_t>{7, -1, 8});
  ASSERT_EQ(log.ticks().size(), 3U);
  const std::vector<CameraSighting>& first = log.ticks()[0].frame->sightings;
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[1].pixel, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(first[1].descriptor, Eigen::Vector2f(0.3F, 0.4F));
  EXPECT_EQ(first[0].landmark_id, 7);
  EXPECT_FALSE(first[1].landmark_id);
  EXPECT_TRUE(log.ticks()[1].frame->sightings.empty());
  EXPECT_EQ(log.ticks()[2].frame->sightings[0].landmark_id, 8);
  const Eigen::MatrixXf none(0, 0);
  EXPECT_THROW(log.add_frames(times({4.0}), pixel, {2}, none, std::nullopt), InvalidArgument);          // a sighting is left over
  EXPECT_THROW(log.add_frames(times({4.0, 5.0}), pixel, {4, 0}, none, std::nullopt), InvalidArgument);  // and one too few
  EXPECT_THROW(log.add_frames(times({4.0}), pixel, {3}, descriptor.topRows(2), std::nullopt), InvalidArgument);
}

TEST(NavigationLog, AVelocityWithoutBottomLockMayBeAnything) {
  NavigationLog log;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  log.add_velocity(times({0.0}), Eigen::RowVector3d(nan, nan, nan), {false});
  EXPECT_FALSE(log.ticks()[0].velocity->bottom_lock);
  EXPECT_THROW(log.add_velocity(times({1.0}), Eigen::RowVector3d(nan, 0.0, 0.0), {true}), InvalidArgument);
}

TEST(NavigationLog, AFaultIsNamedWithItsRow) {
  NavigationLog log;
  try {
    log.add_depth(times({0.0, 2.0, 1.0}), times({1.0, 1.0, 1.0}));
    FAIL() << "a time that goes back was taken";
  } catch (const InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("row 3"), std::string::npos) << error.what();
  }
  EXPECT_THROW(log.add_attitude(times({0.0}), Eigen::RowVector2d(0.0, 0.0)), InvalidArgument);
  EXPECT_THROW(log.add_altitude(times({0.0}), times({1.0, 2.0})), InvalidArgument);
  EXPECT_TRUE(log.ticks().empty());
}

}  // namespace
}  // namespace ssjs
