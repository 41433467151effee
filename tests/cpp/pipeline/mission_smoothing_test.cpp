#include "ssjs/pipeline/mission_smoothing.hpp"

#include <gtest/gtest.h>

#include "pipeline/short_survey.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/pipeline/mission_run.hpp"

namespace ssjs {
namespace {

using testing::ShortSurvey;
using testing::truth_at;

double rmse_m(const MissionResult& result, const SimulatedMission& mission) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < result.pose.rows(); ++i) {
    sum += (result.pose.row(i).head<2>().transpose() - truth_at(mission, result.time_s(i)).translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(result.pose.rows()));
}

TEST(MissionSmoothing, IsNoWorseThanTheJoinedMap) {
  for (const AssociationMethod method : {AssociationMethod::kKnown, AssociationMethod::kJointCompatibility}) {
    ShortSurvey survey(120.0);
    survey.config.association.method = method;
    const MissionResult joined = run_mission(survey.config, survey.mission.events, 5);
    EXPECT_FALSE(joined.smoothing.has_value());
    survey.config.smoothing.enabled = true;
    const MissionResult smoothed = run_mission(survey.config, survey.mission.events, 5);
    ASSERT_TRUE(smoothed.smoothing.has_value());
    EXPECT_TRUE(smoothed.smoothing->converged);
    EXPECT_LT(smoothed.smoothing->half_chi_squared_final, smoothed.smoothing->half_chi_squared_initial);
    // every sighting has 2 numbers, every landmark takes 2: mean chi-squared, and 6 of its standard deviations
    const double dof = 2.0 * smoothed.smoothing->sightings - 2.0 * smoothed.smoothing->landmarks;
    EXPECT_NEAR(2.0 * smoothed.smoothing->half_chi_squared_final, dof, 6.0 * std::sqrt(2.0 * dof));
    EXPECT_LE(rmse_m(smoothed, survey.mission), 1.02 * rmse_m(joined, survey.mission));
    EXPECT_EQ(smoothed.online_pose, joined.online_pose);
    EXPECT_EQ(smoothed.pose.rows(), joined.pose.rows());
  }
}

TEST(MissionSmoothing, EverySightingOfTheRunIsUsedOnce) {
  for (const AssociationMethod method : {AssociationMethod::kKnown, AssociationMethod::kJointCompatibility}) {
    ShortSurvey survey(120.0);
    survey.config.association.method = method;
    SlamPipeline pipeline(survey.config, 5);
    MissionSmoothing smoothing(survey.config);
    int used = 0;
    for (const Event& event : survey.mission.events) {
      const StepReport step = pipeline.feed(event);
      smoothing.feed(event, step.scan);
      if (step.scan) used += step.scan->paired + step.scan->added;
    }
    pipeline.finish();
    std::vector<LandmarkEstimate> landmarks = pipeline.world().landmarks;
    const SmoothingProblem problem = smoothing.problem(pipeline.trajectory(), landmarks);
    EXPECT_EQ(static_cast<int>(problem.sightings.size()), used);
    std::vector<int> sightings(landmarks.size(), 0);
    for (const SightingFactor& sighting : problem.sightings) ++sightings[static_cast<std::size_t>(sighting.landmark)];
    for (std::size_t i = 0; i < landmarks.size(); ++i) EXPECT_EQ(sightings[i], landmarks[i].landmark.times_seen) << i;
    EXPECT_EQ(problem.motions.size() + 1, problem.poses.size());
  }
}

/// 1 m/s straight ahead, the landmark 10 m ahead seen at 2 s and at 3 s.
struct StraightLine {
  SlamConfig config;
  std::vector<Event> events;
  ScanResult scan;
  std::vector<TrajectoryPoint> trajectory;
  std::vector<LandmarkEstimate> landmarks;

  StraightLine() {
    config.vehicle.kind = VehicleKind::kUnicycle;
    for (const double time_s : {0.0, 1.0, 2.0, 3.0, 4.0}) {
      events.push_back({time_s, VelocityControl{1.0, 0.0}});
      trajectory.push_back({time_s, {Se2{time_s, 0.0, 0.0}, Eigen::Matrix3d::Identity()}});
    }
    const Eigen::Vector2d variance(0.01, 0.0004);
    scan.used = {{{{8.0, 0.0}, variance.asDiagonal(), std::nullopt}, 0}};
    landmarks.push_back({{{10.0, 0.0}, Eigen::Matrix2d::Identity()}, {1, std::nullopt, {0}}, 0});
  }
  void feed(MissionSmoothing& smoothing) {
    for (std::size_t i = 0; i < events.size(); ++i) {
      scan.used[0].feature.range_bearing.x() = i == 2 ? 8.0 : 7.3;
      smoothing.feed(events[i], i == 2 || i == 3 ? std::optional<ScanResult>(scan) : std::nullopt);
    }
  }
};

TEST(MissionSmoothing, B11_TheMotionBetweenScansIsTheFiltersPrediction) {
  StraightLine line;
  MissionSmoothing smoothing(line.config);
  line.feed(smoothing);
  const SmoothingProblem problem = smoothing.problem(line.trajectory, line.landmarks);
  ASSERT_EQ(problem.poses.size(), 3U);  // start, 2 s, 3 s
  ASSERT_EQ(problem.sightings.size(), 2U);
  EXPECT_EQ(problem.sightings[1].pose, 2);
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Se2 pose;
  for (int i = 0; i < 2; ++i) {
    const MotionPrediction step = predict_unicycle(pose, {1.0, 0.0}, 1.0, line.config.vehicle.unicycle);
    P = step.F * P * step.F.transpose() + step.Q;
    pose = step.submap_T_vehicle;
  }
  EXPECT_EQ(problem.motions[0].from_T_to.mean.vector(), pose.vector());
  EXPECT_LE((problem.motions[0].from_T_to.covariance - P).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(MissionSmoothing, B13_AStepHalfWayTakesHalfOfTheCorrection) {
  StraightLine line;
  MissionSmoothing smoothing(line.config);
  line.feed(smoothing);
  const SmoothedMission smoothed = smoothing.smooth(line.trajectory, line.landmarks);
  ASSERT_EQ(smoothed.trajectory.size(), 5U);
  const auto x = [&](std::size_t i) { return smoothed.trajectory[i].global_T_vehicle.mean.x; };
  EXPECT_NEAR(x(0), 0.0, 1e-12);
  // Speed noise: variance (0.05 m/s)^2 * 0.1 s a second. Between 2 s and 3 s two ranges of variance 0.01 say 0.7 m, the motion says 1 m.
  const double q = 0.05 * 0.05 * 0.1;
  const double correction = 0.3 * q / (q + 2.0 * 0.01);
  EXPECT_NEAR(x(2), 2.0, 1e-6);  // the first leg is not contradicted: the landmark is nowhere else known
  EXPECT_NEAR(x(3) - x(2), 1.0 - correction, 1e-6);
  EXPECT_NEAR(x(1), 0.5 * (x(0) + x(2)), 1e-9);
  EXPECT_NEAR(x(4), x(3) + 1.0, 1e-9);  // (B-14)
  const auto variance = [&](std::size_t i) { return smoothed.trajectory[i].global_T_vehicle.covariance(0, 0); };
  EXPECT_NEAR(variance(1), q, 1e-9);
  EXPECT_NEAR(variance(2), 2.0 * q, 1e-9);
  EXPECT_GT(variance(4), variance(3));
}

TEST(MissionSmoothing, WithoutObservationsItIsDeadReckoning) {
  ShortSurvey survey(20.0);
  std::vector<Event> blind;
  for (const Event& event : survey.mission.events) {
    if (!std::holds_alternative<Features>(event.record)) blind.push_back(event);
  }
  survey.config.smoothing.enabled = true;
  const MissionResult result = run_mission(survey.config, blind, 5);
  EXPECT_EQ(result.smoothing->half_chi_squared_final, 0.0);
  EXPECT_EQ(result.smoothing->poses, 1);
  EXPECT_LE((result.pose - result.dead_reckoning).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LE((result.covariance - result.online_covariance).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(MissionSmoothing, AStandingVehicleHasOnePose) {
  StraightLine line;
  for (Event& event : line.events) event.record = VelocityControl{0.0, 0.0};
  MissionSmoothing smoothing(line.config);
  line.feed(smoothing);
  const SmoothingProblem problem = smoothing.problem(line.trajectory, line.landmarks);
  EXPECT_EQ(problem.poses.size(), 1U);
  EXPECT_EQ(problem.sightings.size(), 2U);
}

TEST(MissionSmoothing, CovarianceOnRequestOnly) {
  StraightLine line;
  line.config.smoothing.covariance = false;
  MissionSmoothing smoothing(line.config);
  line.feed(smoothing);
  const SmoothedMission smoothed = smoothing.smooth(line.trajectory, line.landmarks);
  EXPECT_EQ(smoothed.trajectory[3].global_T_vehicle.covariance, Eigen::Matrix3d::Identity());  // as before
  EXPECT_EQ(smoothed.landmarks[0].position.covariance, Eigen::Matrix2d::Identity());
}

TEST(MissionSmoothing, RefusesLandmarksOfUnknownOrigin) {
  StraightLine line;
  line.landmarks[0].landmark.tracks.clear();
  MissionSmoothing smoothing(line.config);
  line.feed(smoothing);
  EXPECT_THROW((void)smoothing.smooth(line.trajectory, line.landmarks), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
