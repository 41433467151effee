#include "ssjs/pipeline/mission_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/short_survey.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::ShortSurvey;

TEST(MissionRun, HoldsWhatThePipelineSaid) {
  const ShortSurvey survey(60.0);
  SlamPipeline pipeline(survey.config, 5);
  std::vector<GaussianSe2> online;
  for (const Event& event : survey.mission.events) online.push_back(pipeline.feed(event).global_T_vehicle);
  pipeline.finish();
  const std::vector<TrajectoryPoint> trajectory = pipeline.trajectory();
  std::vector<double> fractions;
  const MissionResult result = run_mission(survey.config, survey.mission.events, 5, [&](double fraction) {
    fractions.push_back(fraction);
    return true;
  });
  const auto n = static_cast<Eigen::Index>(survey.mission.events.size());
  ASSERT_EQ(result.time_s.size(), n);
  ASSERT_EQ(result.submap.size(), survey.mission.events.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    EXPECT_EQ(result.time_s(i), survey.mission.events[at].time_s);
    EXPECT_EQ(Eigen::Vector3d(result.online_pose.row(i)), online[at].mean.vector());
    EXPECT_EQ(Eigen::Vector3d(result.pose.row(i)), trajectory[at].global_T_vehicle.mean.vector());
    const Eigen::Matrix3d& P = trajectory[at].global_T_vehicle.covariance;
    EXPECT_EQ(result.covariance(i, 0), P(0, 0));
    EXPECT_EQ(result.covariance(i, 2), P(0, 2));
    EXPECT_EQ(result.covariance(i, 4), P(1, 2));
    EXPECT_EQ(result.covariance(i, 5), P(2, 2));
  }
  EXPECT_EQ(result.submaps.size(), pipeline.submaps().size());
  EXPECT_TRUE(result.submaps.front().steps.empty());
  EXPECT_EQ(result.world.landmarks.size(), pipeline.world().landmarks.size());
  EXPECT_EQ(fractions.front(), 0.0);
  EXPECT_EQ(fractions.back(), 1.0);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
}

TEST(MissionRun, CanBeCancelled) {
  const ShortSurvey survey(10.0);
  EXPECT_THROW((void)run_mission(survey.config, survey.mission.events, 5, [](double fraction) { return fraction < 0.5; }), Cancelled);
  const MissionResult empty = run_mission(survey.config, {}, 5);
  EXPECT_EQ(empty.pose.rows(), 0);
  EXPECT_TRUE(empty.submaps.empty());
}

}  // namespace
}  // namespace ssjs
