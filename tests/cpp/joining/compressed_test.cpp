#include "ssjs/joining/compressed.hpp"

#include <gtest/gtest.h>

#include "joining/drive.hpp"
#include "joining/equal_answers.hpp"
#include "pipeline/short_survey.hpp"
#include "ssjs/pipeline/mapper_factory.hpp"

namespace ssjs {
namespace {

using testing::AnswerDifference;
using testing::drive;
using testing::ShortSurvey;

constexpr double kSame = 1e-9;  // relative to the covariances, and m for means: the project's bar for this method

WorldEstimate ekf_answer(const ShortSurvey& survey, double until_s) {
  SlamConfig config = survey.config;
  config.method = Method::kEkf;
  const std::unique_ptr<Mapper> ekf = make_mapper(config, 1);
  drive(*ekf, survey.mission, config.vehicle.ackerman, until_s, [](const Event&, const std::optional<MapperReport>&) {});
  static_cast<void>(ekf->finish());
  return ekf->world(BaseCovariance::kJoint);
}

TEST(CompressedEkf, G6_G10_EqualsTheEkfThroughRegionChanges) {
  ShortSurvey survey(200.0);
  for (const AssociationMethod association : {AssociationMethod::kKnown, AssociationMethod::kJointCompatibility}) {
    survey.config.association.method = association;
    CompressedEkfMapper mapper({}, 8.0, survey.config.submap, survey.config.association, 1);
    drive(mapper, survey.mission, survey.config.vehicle.ackerman, 1e9, [](const Event&, const std::optional<MapperReport>&) {});
    EXPECT_GE(mapper.region_changes(), 20);
    const WorldEstimate on_demand = mapper.world(BaseCovariance::kJoint);
    static_cast<void>(mapper.finish());
    const WorldEstimate ekf = ekf_answer(survey, 1e9);
    for (const WorldEstimate& world : {on_demand, mapper.world(BaseCovariance::kJoint)}) {
      const AnswerDifference difference(world, ekf);
      EXPECT_LE(difference.mean_m, kSame);
      EXPECT_LE(difference.relative_covariance, kSame);
      EXPECT_EQ(difference.sightings, 0);
      EXPECT_LE(additive_difference(world.global_T_base.back(), ekf.global_T_base.back()).norm(), kSame);
      EXPECT_LE((world.base_covariance - ekf.base_covariance).cwiseAbs().maxCoeff(), kSame * ekf.base_covariance.trace());
    }
  }
}

TEST(CompressedEkf, G11_ALandmarkSeenFromOutsideItsRegionIsFetched) {
  // Regions far smaller than the sensor's range: nearly every scan shows passive landmarks, and the answer is the same.
  const ShortSurvey survey(40.0);
  CompressedEkfConfig tiny;
  tiny.region_m = 0.5;
  tiny.sight_m = 0.1;
  CompressedEkfMapper mapper(tiny, 8.0, survey.config.submap, survey.config.association, 1);
  drive(mapper, survey.mission, survey.config.vehicle.ackerman, 1e9, [](const Event&, const std::optional<MapperReport>&) {});
  static_cast<void>(mapper.finish());
  EXPECT_GE(mapper.region_changes(), 100);  // of 133 scans
  const AnswerDifference difference(mapper.world(BaseCovariance::kJoint), ekf_answer(survey, 1e9));
  EXPECT_LE(difference.mean_m, kSame);
  EXPECT_LE(difference.relative_covariance, kSame);
}

TEST(CompressedEkf, TentativeLandmarksComeAndGo) {
  ShortSurvey survey(80.0);
  survey.config.submap.min_sightings = 4;
  survey.config.submap.prune_after_scans = 6;
  CompressedEkfMapper mapper({}, 8.0, survey.config.submap, survey.config.association, 1);
  drive(mapper, survey.mission, survey.config.vehicle.ackerman, 1e9, [](const Event&, const std::optional<MapperReport>&) {});
  static_cast<void>(mapper.finish());
  const WorldEstimate world = mapper.world(BaseCovariance::kJoint);
  for (const LandmarkEstimate& landmark : world.landmarks) {
    EXPECT_GE(landmark.landmark.times_seen, 4);
    const Eigen::Vector2d truth = survey.mission.world.landmarks_m.col(static_cast<Eigen::Index>(*landmark.landmark.source_id));
    EXPECT_LE((landmark.position.mean - truth).norm(), 5.0);
    EXPECT_GT(landmark.position.covariance.determinant(), 0.0);
  }
  EXPECT_GE(world.landmarks.size(), 50U);
  EXPECT_GE(mapper.region_changes(), 10);
}

}  // namespace
}  // namespace ssjs
