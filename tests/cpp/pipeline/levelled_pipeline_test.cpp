#include "ssjs/pipeline/levelled_pipeline.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/levelled_run.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {
namespace {

constexpr double kTrueOffset = 0.7;  // compass reading minus heading at the start of the simulated survey

SimulatedSurvey survey(std::uint64_t seed) { return simulate_survey(survey_world(SurveyWorldConfig{}, seed), AuvSimulationConfig{}, seed); }

LevelledConfig known_identities() {
  LevelledConfig config;
  config.local.association.method = AssociationMethod::kKnown;
  return config;
}

double rmse_m(const RowMatrix& pose, const Eigen::VectorXd& time_s, const SimulatedSurvey& truth) {
  double sum = 0.0;
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < pose.rows(); ++i) {
    while (truth.truth[at].time_s < time_s(i)) ++at;
    sum += (pose.row(i).head<2>().transpose() - truth.truth[at].world_T_vehicle.translation.head<2>()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(pose.rows()));
}

TEST(DeadReckoning, AStraightLineToTheEastWithTheOffsetKnown) {
  DeadReckoning reckoning(VelocityLogConfig{}, 0.2);
  for (int i = 0; i <= 100; ++i) {
    NavigationTick tick;
    tick.time_s = 0.1 * i;
    tick.compass_rad = 0.2 + M_PI / 2.0;
    tick.velocity = VelocitySample{{2.0, 0.0, 0.0}, true, std::nullopt};
    if (i > 50) tick.velocity->bottom_lock = false;  // the last velocity holds
    tick.depth_m = 12.0;
    reckoning.feed(tick);
  }
  const Se3 reached = reckoning.start_T_vehicle();
  EXPECT_NEAR(reached.translation.x(), 0.0, 1e-9);
  EXPECT_NEAR(reached.translation.y(), 20.0, 1e-9);
  EXPECT_EQ(reached.translation.z(), 12.0);
}

TEST(LevelledPipeline, TiedMapsAreBetterThanTheSensorsAlone) {
  for (const std::uint64_t seed : {3U, 4U}) {
    const SimulatedSurvey simulated = survey(seed);
    const LevelledResult result = run_levelled_mission(known_identities(), simulated.ticks);
    EXPECT_GT(result.submaps.size(), 5U);
    EXPECT_GT(result.loop_closures, 10);
    EXPECT_LT(rmse_m(result.pose, result.time_s, simulated), 0.7);
    EXPECT_LT(rmse_m(result.pose, result.time_s, simulated), 0.6 * rmse_m(result.dead_reckoning, result.time_s, simulated));
    EXPECT_EQ(result.ticks, static_cast<int>(simulated.ticks.size()));
  }
}

TEST(LevelledPipeline, OneMapForTheWholeMissionIsNeverClosed) {
  LevelledConfig config = known_identities();
  config.method = LevelledMethod::kOneMap;
  const SimulatedSurvey simulated = survey(3);
  const LevelledResult result = run_levelled_mission(config, simulated.ticks);
  EXPECT_EQ(result.submaps.size(), 1U);
  EXPECT_LT(rmse_m(result.pose, result.time_s, simulated), 0.7);
  // what was seen again late corrects the way before it
  EXPECT_LT(rmse_m(result.pose, result.time_s, simulated), 0.8 * rmse_m(result.online_pose, result.time_s, simulated));
}

/// Share of the remembered poses whose x and y both lie within three of their standard deviations.
double share_inside(const LevelledResult& result, const SimulatedSurvey& truth) {
  int inside = 0;
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < result.pose.rows(); ++i) {
    while (truth.truth[at].time_s < result.time_s(i)) ++at;
    const Eigen::Vector2d error = result.pose.row(i).head<2>().transpose() - truth.truth[at].world_T_vehicle.translation.head<2>();
    const double sigma_x = std::sqrt(result.covariance(i, 0));
    const double sigma_y = std::sqrt(result.covariance(i, 6));  // second row of the upper triangle
    if (std::abs(error.x()) <= 3.0 * sigma_x + 1e-6 && std::abs(error.y()) <= 3.0 * sigma_y + 1e-6) ++inside;
  }
  return static_cast<double>(inside) / static_cast<double>(result.pose.rows());
}

TEST(LevelledPipeline, U2_EveryMethodOfThePlaneFollowsTheSurvey) {
  const SimulatedSurvey simulated = survey(3);
  LevelledConfig config = known_identities();
  for (const LevelledMethod method : {LevelledMethod::kSequential, LevelledMethod::kDivideAndConquer, LevelledMethod::kHierarchical,
                                      LevelledMethod::kConstrainedLocal, LevelledMethod::kFused}) {
    config.method = method;
    const LevelledResult result = run_levelled_mission(config, simulated.ticks);
    EXPECT_GT(result.submaps.size(), 5U) << static_cast<int>(method);
    EXPECT_LT(rmse_m(result.pose, result.time_s, simulated), 0.6 * rmse_m(result.dead_reckoning, result.time_s, simulated));
    EXPECT_GT(share_inside(result, simulated), 0.95) << static_cast<int>(method);
    EXPECT_EQ(result.pose.cols(), 6);
    for (const SurveyLandmark& landmark : result.landmarks) EXPECT_NEAR(landmark.position.z(), 16.0, 1.5);
    EXPECT_EQ(result.map_wrong_pairs, 0);
  }
}

TEST(LevelledPipeline, U7_AHeadingTakenForExactIsTooSureOfItself) {
  const SimulatedSurvey simulated = survey(3);
  LevelledConfig config = known_identities();
  config.method = LevelledMethod::kNaiveHeading;
  EXPECT_LT(share_inside(run_levelled_mission(config, simulated.ticks), simulated), 0.6);
}

TEST(LevelledPipeline, AWorldAlignedToNorthIsTheSameWorldTurned) {
  LevelledConfig config = known_identities();
  const SimulatedSurvey simulated = survey(3);
  const LevelledResult aligned_to_start = run_levelled_mission(config, simulated.ticks);
  config.joining.north_offset_rad = kTrueOffset - 0.5;  // north lies so that the first line heads 0.5 rad
  config.joining.north_offset_sigma_rad = 1e-3;
  const LevelledResult to_north = run_levelled_mission(config, simulated.ticks);
  EXPECT_NEAR(to_north.global_T_base[0].mean.heading, 0.5, 0.02);
  const Eigen::Rotation2Dd turn(to_north.global_T_base[0].mean.heading);
  const Eigen::Index last = to_north.pose.rows() - 1;
  const Eigen::Vector2d expected = turn * aligned_to_start.pose.row(last).head<2>().transpose();
  EXPECT_LT((to_north.pose.row(last).head<2>().transpose() - expected).norm(), 0.05);
  const Eigen::Vector2d online = to_north.online_pose.row(20).head<2>();  // before the first map is closed
  EXPECT_LT((online - turn * aligned_to_start.online_pose.row(20).head<2>().transpose()).norm(), 1.0);
}

TEST(LevelledPipeline, TheSameMissionGivesTheSameNumbers) {
  const SimulatedSurvey simulated = survey(5);
  const LevelledResult a = run_levelled_mission(LevelledConfig{}, simulated.ticks);
  const LevelledResult b = run_levelled_mission(LevelledConfig{}, simulated.ticks);
  EXPECT_EQ(a.pose, b.pose);
  EXPECT_EQ(a.covariance, b.covariance);
}

double final_error_m(const LevelledResult& result, const SimulatedSurvey& simulated) {
  const Eigen::Index last = result.pose.rows() - 1;
  const AuvTruth& truth = simulated.truth.back();
  return (result.pose.row(last).head<2>().transpose() - truth.world_T_vehicle.translation.head<2>()).norm();
}

TEST(LevelledPipeline, ACompassThatJumpsIsMetAnew) {
  SimulatedSurvey simulated = survey(3);
  for (NavigationTick& tick : simulated.ticks) {
    if (tick.time_s > 300.0 && tick.compass_rad) *tick.compass_rad += 0.35;
  }
  const LevelledResult result = run_levelled_mission(known_identities(), simulated.ticks);
  EXPECT_LE(result.compass_jumps, 2);
  EXPECT_LT(final_error_m(result, simulated), 2.0);
}

TEST(LevelledPipeline, ACompassMayBeginLateAndFallSilent) {
  SimulatedSurvey simulated = survey(3);
  for (NavigationTick& tick : simulated.ticks) {
    if (tick.time_s < 100.0 || (tick.time_s > 300.0 && tick.time_s < 450.0)) tick.compass_rad.reset();
  }
  const LevelledResult result = run_levelled_mission(known_identities(), simulated.ticks);
  EXPECT_EQ(result.compass_jumps, 0);
  EXPECT_LT(final_error_m(result, simulated), 2.0);
}

TEST(LevelledPipeline, AfterASilenceOfHoursOrYearsTheVehicleMayBeAnywhere) {
  for (const double silence_s : {600.0, 3600.0, 14000.0, 3e9}) {
    SimulatedSurvey simulated = survey(3);
    for (NavigationTick& tick : simulated.ticks) {
      if (tick.time_s > 350.0) tick.time_s += silence_s;
    }
    const LevelledResult result = run_levelled_mission(known_identities(), simulated.ticks);
    double largest = 0.0;
    for (Eigen::Index i = 0; i < result.time_s.size(); ++i) {
      if (result.time_s(i) > 350.0 + silence_s) largest = std::max(largest, result.online_covariance(i, 0));
    }
    EXPECT_GT(std::sqrt(largest), 20.0) << silence_s;
    EXPECT_GE(result.online_covariance.col(0).minCoeff(), 0.0) << silence_s;
  }
}

TEST(LevelledPipeline, NorthWithoutACompassIsRefusedBeforeTheMission) {
  LevelledConfig config;
  config.joining.north_offset_rad = 0.1;
  EXPECT_TRUE(config.violations().empty());
  for (const CompassUse use : {CompassUse::kFirstReading, CompassUse::kNone}) {
    config.local.compass_use = use;
    ASSERT_EQ(config.violations().size(), 1U);
    EXPECT_NE(config.violations().front().find("joining.north_offset_rad"), std::string::npos);
    EXPECT_THROW(LevelledPipeline{config}, InvalidArgument);
  }
  config.local.compass_use = CompassUse::kMean;
  EXPECT_TRUE(config.violations().empty());
  config.method = LevelledMethod::kNaiveHeading;  // whatever compass_use says
  ASSERT_EQ(config.violations().size(), 1U);
  EXPECT_NE(config.violations().front().find("ssjs-naive-heading"), std::string::npos);
}

TEST(LevelledPipeline, AMapWithoutAReadingSaysNothingOfTheMeanOffset) {
  SimulatedSurvey simulated = survey(3);
  for (NavigationTick& tick : simulated.ticks) {
    if (tick.time_s > 300.0 && tick.time_s < 450.0) tick.compass_rad.reset();
  }
  LevelledConfig config = known_identities();
  config.local.compass_use = CompassUse::kMean;
  const LevelledResult result = run_levelled_mission(config, simulated.ticks);
  EXPECT_GT(result.submaps.size(), 5U);
  EXPECT_LT(final_error_m(result, simulated), 2.0);
}

TEST(LevelledPipeline, AMissionEndsOnce) {
  LevelledPipeline pipeline{LevelledConfig{}};
  NavigationTick tick;
  tick.depth_m = 1.0;
  (void)pipeline.feed(tick);
  (void)pipeline.finish();
  EXPECT_THROW((void)pipeline.finish(), InvalidArgument);
  EXPECT_THROW((void)pipeline.feed(tick), InvalidArgument);
}

TEST(LevelledPipeline, AnEmptyLogIsAnEmptyAnswer) {
  const LevelledResult result = run_levelled_mission(LevelledConfig{}, {});
  EXPECT_EQ(result.time_s.size(), 0);
  EXPECT_TRUE(result.submaps.empty());
}

}  // namespace
}  // namespace ssjs
