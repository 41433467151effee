#include "ssjs/pipeline/slam_pipeline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/short_survey.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::ShortSurvey;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Every number of a trajectory.
std::vector<double> numbers(const std::vector<TrajectoryPoint>& trajectory) {
  std::vector<double> all;
  for (const TrajectoryPoint& point : trajectory) {
    all.push_back(point.time_s);
    for (const double x : point.global_T_vehicle.mean.vector()) all.push_back(x);
    all.insert(all.end(), point.global_T_vehicle.covariance.data(), point.global_T_vehicle.covariance.data() + 9);
  }
  return all;
}

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(SlamPipeline, RefusedEventsLeaveNothingBehind) {
  const ShortSurvey survey(30.0);
  SlamPipeline undisturbed(survey.config, 1);
  SlamPipeline disturbed(survey.config, 1);
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0003).asDiagonal();
  const LaserScan flat{Eigen::VectorXd::Constant(10, 5.0), 0.0, 0.0};
  int refused = 0;
  for (std::size_t i = 0; i < survey.mission.events.size(); ++i) {
    const Event& event = survey.mission.events[i];
    undisturbed.feed(event);
    if (i % 50 == 20) {
      const double later = event.time_s;  // not after the event: it would be in order
      const std::vector<Event> bad{{later - 1.0, Features{}},
                                   {kNaN, Features{}},
                                   {later, AckermanControl{kNaN, 0.0}},
                                   {later, AckermanControl{1.0, 1.57}},
                                   {later, VelocityControl{1.0, 0.0}},
                                   {later, OdometryIncrement{}},
                                   {later, Features{{Eigen::Vector2d(kNaN, 0.0), R, 1}}},
                                   {later, Features{{Eigen::Vector2d(-1.0, 0.0), R, 1}}},
                                   {later, Features{{Eigen::Vector2d(1.0, 0.0), -R, 1}}},
                                   {later, LaserScan{Eigen::VectorXd::Constant(10, 5.0), kNaN, 0.1}},
                                   {later, flat},
                                   {later, SonarHits{{{kNaN, 0.0}}}},
                                   {later, SonarHits{{{-1.0, 0.0}}}}};
      for (const Event& broken : bad) {
        const GaussianSe2 before = disturbed.global_T_vehicle();
        EXPECT_THROW(disturbed.feed(broken), Error) << "record " << broken.record.index();
        EXPECT_EQ(disturbed.global_T_vehicle().mean.vector(), before.mean.vector());
        EXPECT_EQ(disturbed.global_T_vehicle().covariance, before.covariance);
        ++refused;
      }
    }
    disturbed.feed(event);
  }
  EXPECT_GT(refused, 50);
  undisturbed.finish();
  disturbed.finish();
  EXPECT_GE(undisturbed.submaps().size(), 3U);
  EXPECT_TRUE(same_bytes(numbers(undisturbed.trajectory()), numbers(disturbed.trajectory())));
}

TEST(SlamPipeline, AMissionEndsOnce) {
  const ShortSurvey survey(5.0);
  SlamPipeline pipeline(survey.config, 1);
  for (const Event& event : survey.mission.events) pipeline.feed(event);
  const GaussianSe2 last = pipeline.global_T_vehicle();
  pipeline.finish();
  EXPECT_LE(additive_difference(pipeline.global_T_vehicle().mean, last.mean).norm(), 1e-9);  // no loop has moved it
  try {
    pipeline.feed({100.0, Features{}});
    FAIL() << "an event was taken after the end";
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(std::string(error.what()), "event = 100: the mission is finished");
  }
  EXPECT_THROW(pipeline.finish(), InvalidArgument);
  EXPECT_EQ(pipeline.trajectory().size(), survey.mission.events.size());
}

TEST(SlamPipeline, AnEmptyMissionEndsWhereItBegan) {
  SlamPipeline pipeline(SlamConfig(), 1);
  EXPECT_TRUE(pipeline.finish().loops.empty());
  EXPECT_TRUE(pipeline.trajectory().empty());
  EXPECT_EQ(pipeline.global_T_vehicle().mean.vector(), Eigen::Vector3d::Zero());
  EXPECT_EQ(pipeline.world().landmarks.size(), 0U);
}

TEST(SlamPipeline, EveryMethodTakesAnEmptyMissionAndEmptyScans) {
  for (const Method method : {Method::kAugmentedEkf, Method::kCompressedEkf, Method::kConditionallyIndependent}) {
    SlamConfig config;
    config.method = method;
    SlamPipeline empty(config, 1);
    EXPECT_TRUE(empty.finish().loops.empty());
    EXPECT_TRUE(empty.trajectory().empty());
    SlamPipeline pipeline(config, 1);
    pipeline.feed({0.0, AckermanControl{1.0, 0.1}});
    pipeline.feed({1.0, Features{}});
    pipeline.feed({2.0, Features{}});
    pipeline.finish();
    EXPECT_EQ(pipeline.trajectory().size(), 3U);
    EXPECT_EQ(pipeline.submaps().size(), 1U);
    EXPECT_EQ(pipeline.world().landmarks.size(), 0U);
  }
}

TEST(SlamPipeline, HoldsAVelocityUntilTheNext) {
  SlamConfig config;
  config.vehicle.kind = VehicleKind::kUnicycle;
  SlamPipeline pipeline(config, 1);
  pipeline.feed({10.0, VelocityControl{2.0, 0.0}});  // nothing has happened yet
  EXPECT_EQ(pipeline.global_T_vehicle().mean.vector(), Eigen::Vector3d::Zero());
  EXPECT_EQ(pipeline.global_T_vehicle().covariance, Eigen::Matrix3d::Zero());
  pipeline.feed({11.5, VelocityControl{0.0, kPi / 2.0}});
  EXPECT_LE((pipeline.global_T_vehicle().mean.vector() - Eigen::Vector3d(3.0, 0.0, 0.0)).norm(), 1e-12);
  pipeline.feed({12.5, Features{}});
  EXPECT_LE((pipeline.dead_reckoning().vector() - Eigen::Vector3d(3.0, 0.0, kPi / 2.0)).norm(), 1e-12);
}

TEST(SlamPipeline, AddsMeasuredIncrements) {
  SlamConfig config;
  config.vehicle.kind = VehicleKind::kIncrements;
  SlamPipeline pipeline(config, 1);
  const OdometryIncrement corner{{{1.0, 0.0, kPi / 2.0}, Eigen::Vector3d(0.01, 0.01, 0.0001).asDiagonal()}};
  for (int i = 1; i <= 3; ++i) pipeline.feed({static_cast<double>(i), corner});
  EXPECT_LE(additive_difference(pipeline.global_T_vehicle().mean, {0.0, 1.0, -kPi / 2.0}).norm(), 1e-12);
}

TEST(SlamPipeline, WithoutLandmarksTheAnswerIsDeadReckoning) {
  ShortSurvey survey(20.0);
  for (const Method method :
       {Method::kSelective, Method::kEkf, Method::kAugmentedEkf, Method::kCompressedEkf, Method::kConditionallyIndependent}) {
    survey.config.method = method;
    SlamPipeline pipeline(survey.config, 1);
    std::vector<Se2> dead_reckoning;
    for (const Event& event : survey.mission.events) {
      if (std::holds_alternative<Features>(event.record)) continue;
      const StepReport step = pipeline.feed(event);
      dead_reckoning.push_back(pipeline.dead_reckoning());
      EXPECT_EQ(step.submap, 0);
      EXPECT_LE(additive_difference(step.global_T_vehicle.mean, pipeline.dead_reckoning()).norm(), 1e-12);
    }
    pipeline.finish();
    const std::vector<TrajectoryPoint> trajectory = pipeline.trajectory();
    ASSERT_EQ(trajectory.size(), dead_reckoning.size());
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      EXPECT_LE(additive_difference(trajectory[i].global_T_vehicle.mean, dead_reckoning[i]).norm(), 1e-9) << i;
    }
    EXPECT_EQ(pipeline.submaps().size(), 1U);
  }
}

TEST(SlamPipeline, ReportsWhatEveryEventDid) {
  const ShortSurvey survey(30.0);
  SlamPipeline pipeline(survey.config, 1);
  int closed = 0;
  int observations = 0;
  int seen = 0;
  for (const Event& event : survey.mission.events) {
    const StepReport step = pipeline.feed(event);
    EXPECT_EQ(step.time_s, event.time_s);
    EXPECT_EQ(step.scan.has_value(), std::holds_alternative<Features>(event.record));
    if (step.scan) {
      EXPECT_FALSE(step.scan->closed);  // the submap went to the joining layer
      observations += step.scan->paired + step.scan->added + step.scan->dropped;
      seen += static_cast<int>(std::get<Features>(event.record).size());
    }
    closed += step.join ? 1 : 0;
    EXPECT_EQ(step.submap, closed);
    EXPECT_GE(step.global_time_s, 0.0);
    EXPECT_GE(step.association_time_s, 0.0);
  }
  EXPECT_EQ(observations, seen);  // each is used once, at the borders too
  pipeline.finish();
  ASSERT_EQ(pipeline.submaps().size(), static_cast<std::size_t>(closed) + 1);
  EXPECT_EQ(pipeline.submaps().back().closed_because, "end of the mission");
  EXPECT_EQ(pipeline.world().global_T_base.size(), pipeline.submaps().size() + 1);
  for (std::size_t k = 1; k < pipeline.submaps().size(); ++k) {
    EXPECT_EQ(pipeline.submaps()[k].start_time_s, pipeline.submaps()[k - 1].end_time_s);
  }
}

TEST(SlamPipeline, SameSeedSameBytes) {
  // Half the mission with unknown association: joint compatibility, ambiguity gate, fusions.
  ShortSurvey survey(300.0);
  survey.config.association.method = AssociationMethod::kJointCompatibility;
  survey.config.joining.max_pairing_sigma_m = 0.8;
  const auto run = [&] {
    SlamPipeline pipeline(survey.config, 11);
    for (const Event& event : survey.mission.events) pipeline.feed(event);
    pipeline.finish();
    std::vector<double> all = numbers(pipeline.trajectory());
    for (const LandmarkEstimate& landmark : pipeline.world().landmarks) {
      all.insert(all.end(), landmark.position.mean.data(), landmark.position.mean.data() + 2);
      all.insert(all.end(), landmark.position.covariance.data(), landmark.position.covariance.data() + 4);
    }
    const Eigen::MatrixXd P = pipeline.world(BaseCovariance::kJoint).base_covariance;
    all.insert(all.end(), P.data(), P.data() + P.size());
    return all;
  };
  const std::vector<double> first = run();
  EXPECT_TRUE(same_bytes(first, run()));
  EXPECT_GT(first.size(), 10000U);
}

class OneEndlessMap : public ::testing::TestWithParam<Method> {};

TEST_P(OneEndlessMap, AnswersWithWhatItFiltered) {
  ShortSurvey survey(60.0);
  survey.config.method = GetParam();
  SlamPipeline pipeline(survey.config, 1);
  std::vector<GaussianSe2> online;
  for (const Event& event : survey.mission.events) online.push_back(pipeline.feed(event).global_T_vehicle);
  pipeline.finish();
  EXPECT_EQ(pipeline.submaps().size(), 1U);
  const std::vector<TrajectoryPoint> trajectory = pipeline.trajectory();
  for (std::size_t i = 0; i < trajectory.size(); i += 31) {  // its answer is what it filtered at the time
    EXPECT_LE(additive_difference(trajectory[i].global_T_vehicle.mean, online[i].mean).norm(), 1e-12);
    EXPECT_LE((trajectory[i].global_T_vehicle.covariance - online[i].covariance).cwiseAbs().maxCoeff(), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(SlamPipeline, OneEndlessMap, ::testing::Values(Method::kEkf, Method::kAugmentedEkf, Method::kCompressedEkf));

}  // namespace
}  // namespace ssjs
