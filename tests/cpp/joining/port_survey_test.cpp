/// Simulated surveys through the filter of levelled maps and their ports: docs/math/ports.md, "How well it works".
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "joining/levelled_world.hpp"
#include "joining/survey_bases.hpp"
#include "mapping/survey_run.hpp"
#include "ssjs/joining/port_estimate.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {
namespace {

/// What a survey does with its compass, and the maps with each other.
struct Variant {
  const char* name = "";
  CompassUse compass = CompassUse::kFilter;
  double drift_rad_sqrt_s = 0.0;  ///< of the compass in the maps (filter) or between them (mean); 0: constant
  bool landmarks = true;
  AssociationMethod association = AssociationMethod::kKnown;
  PortSolver solver = PortSolver::kBatch;
};

struct Survey {
  testing::BaseErrors bases;
  double final_m = 0.0;
  double way_rmse_m = 0.0;       ///< of all steps, x and y
  double way_inside = 0.0;       ///< steps whose x, y and depth are each within three standard deviations
  double landmark_rmse_m = 0.0;  ///< of the landmarks seen by two maps or more, x and y
  int maps = 0, ports = 0, pairs = 0, wrong = 0;

  Survey& operator+=(const Survey& other) {
    bases.joint_per_dof += other.bases.joint_per_dof;
    bases.position += other.bases.position;
    bases.heading += other.bases.heading;
    bases.rmse_m += other.bases.rmse_m;
    final_m += other.final_m;
    way_rmse_m += other.way_rmse_m;
    way_inside += other.way_inside;
    landmark_rmse_m += other.landmark_rmse_m;
    maps += other.maps;
    ports += other.ports;
    pairs += other.pairs;
    wrong += other.wrong;
    return *this;
  }
};

SimulatedSurvey simulate(std::uint64_t seed) { return simulate_survey(ssjs::survey_world({}, seed), AuvSimulationConfig{}, seed); }

void judge_way(const PortJoiner& joiner, const SimulatedSurvey& survey, Survey& result) {
  const Se2 base_T_world = testing::level_pose(survey.truth.front()).inverse();
  int count = 0;
  for (const PortMap& map : joiner.maps()) {
    for (const SurveyStep& step : steps_in_world(map, joiner.level())) {
      const AuvTruth& truth = testing::truth_at(survey, step.time_s);
      const Se2 pose = base_T_world * testing::level_pose(truth);
      Eigen::Vector3d error;
      error << pose.translation() - step.global_T_vehicle.head<2>(), truth.world_T_vehicle.translation.z() - step.global_T_vehicle(2);
      const Eigen::Array3d sigma = step.covariance.diagonal().head<3>().array().sqrt();
      result.way_rmse_m += error.head<2>().squaredNorm();
      result.way_inside += (error.array().abs() <= 3.0 * sigma).all() ? 1.0 : 0.0;
      ++count;
    }
  }
  result.way_rmse_m = std::sqrt(result.way_rmse_m / count);
  result.way_inside /= count;
}

void judge_landmarks(const PortJoiner& joiner, const SimulatedSurvey& survey, Survey& result) {
  const Se2 base_T_world = testing::level_pose(survey.truth.front()).inverse();
  int count = 0;
  for (const SurveyLandmark& landmark : landmarks_in_world(joiner.maps(), joiner.level())) {
    if (landmark.maps.size() < 2) continue;
    const Eigen::Vector3d truth = survey.world.landmarks_m.col(static_cast<Eigen::Index>(*landmark.landmark.source_id));
    result.landmark_rmse_m += (base_T_world * Eigen::Vector2d(truth.head<2>()) - landmark.position.head<2>()).squaredNorm();
    ++count;
  }
  if (count > 0) result.landmark_rmse_m = std::sqrt(result.landmark_rmse_m / count);
}

Survey run(const SimulatedSurvey& survey, const Variant& variant) {
  LevelledBuilderConfig building = testing::matched({});
  testing::split_every(building, 50.0);
  building.compass_use = variant.compass;
  if (variant.compass == CompassUse::kFilter) building.motion.compass_walk_rad_sqrt_s = variant.drift_rad_sqrt_s;
  PortJoinerConfig joining;
  joining.association = variant.association;
  joining.solver = variant.solver;
  if (variant.compass == CompassUse::kMean) joining.offset_drift_rad_per_sqrt_s = variant.drift_rad_sqrt_s;

  const std::vector<LevelledSubmap> maps = testing::build_maps(survey, building);
  PortJoiner joiner(joining);
  Survey result;
  for (LevelledSubmap map : maps) {
    if (!variant.landmarks) {
      for (MapLandmark& landmark : map.landmarks) landmark.source_id.reset();  // nothing is found again
    }
    for (const LoopAttempt& loop : joiner.take(std::move(map)).loops) {
      result.pairs += loop.pairs;
      result.wrong += loop.wrong_pairs.value_or(0);
    }
  }
  joiner.finish();
  const std::vector<Se2> truth = testing::true_bases(survey, maps);
  result.bases = testing::base_errors(joiner.level(), truth);
  result.final_m = (joiner.level().values().bases.back().translation() - truth.back().translation()).norm();
  result.maps = static_cast<int>(maps.size());
  result.ports = static_cast<int>(joiner.level().values().landmarks.size());
  judge_way(joiner, survey, result);
  if (variant.landmarks) judge_landmarks(joiner, survey, result);
  return result;
}

/// Compass minus its first reading, velocity log, gyro: positions where the maps begin.
double dead_reckoning_rmse(SimulatedSurvey survey) {
  LevelledBuilderConfig config = testing::matched({});
  config.compass_use = CompassUse::kFirstReading;
  testing::never_split(config);
  for (NavigationTick& tick : survey.ticks) tick.sightings.clear();
  const LevelledSubmap whole = testing::build_maps(survey, config).front();
  const Se2 base_T_world = testing::level_pose(survey.truth.front()).inverse();
  double sum = 0.0;
  for (const LevelledStep& step : whole.steps) {
    const Se2 pose = base_T_world * testing::level_pose(testing::truth_at(survey, step.time_s));
    sum += (pose.translation() - step.base_T_vehicle.head<2>()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(whole.steps.size()));
}

/// Means over the surveys.
Survey mean_of(const std::vector<SimulatedSurvey>& surveys, const Variant& variant) {
  Survey sum;
  for (const SimulatedSurvey& survey : surveys) sum += run(survey, variant);
  const auto n = static_cast<double>(surveys.size());
  sum.bases.joint_per_dof /= n;
  sum.bases.position /= n;
  sum.bases.heading /= n;
  sum.bases.rmse_m /= n;
  sum.final_m /= n;
  sum.way_rmse_m /= n;
  sum.way_inside /= n;
  sum.landmark_rmse_m /= n;
  std::printf("| %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.3f | %.2f | %.1f | %.1f | %d / %d |\n", variant.name, sum.bases.rmse_m,
              sum.final_m, sum.bases.position, sum.bases.heading, sum.bases.joint_per_dof, sum.way_rmse_m, sum.way_inside,
              sum.landmark_rmse_m, sum.maps / n, sum.ports / n, sum.wrong, sum.pairs);
  return sum;
}

const double kWalk = AuvSimulationConfig{}.motion.compass_walk_rad_sqrt_s;
const Variant kRunning{"running offset, landmark ports", CompassUse::kFilter, kWalk};
const Variant kRecursiveRunning{"the same, recursive", CompassUse::kFilter, kWalk, true, AssociationMethod::kKnown, PortSolver::kRecursive};
const Variant kPaired{"the same, joint compatibility", CompassUse::kFilter, kWalk, true, AssociationMethod::kJointCompatibility};
const Variant kNoLandmarks{"running offset, no landmarks", CompassUse::kFilter, kWalk, false};
const Variant kConstant{"constant offset", CompassUse::kFilter, 0.0};
const Variant kMeanWalk{"a factor per map, offset walks", CompassUse::kMean, kWalk};
const Variant kMeanConstant{"a factor per map, constant offset", CompassUse::kMean, 0.0};
const Variant kFirst{"first reading taken for exact", CompassUse::kFirstReading, kWalk};
const Variant kNone{"no compass", CompassUse::kNone};

std::vector<SimulatedSurvey> simulate_all(int count) {
  std::vector<SimulatedSurvey> surveys;
  for (int seed = 0; seed < count; ++seed) surveys.push_back(simulate(static_cast<std::uint64_t>(seed)));
  return surveys;
}

TEST(PortSurvey, ASurveyIsCorrectedByWhatItSeesTwice) {
  const std::vector<SimulatedSurvey> surveys = simulate_all(3);
  const Survey result = mean_of(surveys, kRunning);
  double reckoned = 0.0;
  for (const SimulatedSurvey& survey : surveys) reckoned += dead_reckoning_rmse(survey) / 3.0;
  EXPECT_LT(result.bases.rmse_m, 0.75);
  EXPECT_GT(reckoned, 1.5 * result.bases.rmse_m);
  EXPECT_GT(result.bases.joint_per_dof, 0.7);
  EXPECT_LT(result.bases.joint_per_dof, 1.4);
  EXPECT_GT(result.way_inside, 0.9);
  EXPECT_GT(mean_of(surveys, kFirst).bases.joint_per_dof, 10.0);  // the dangerous way is visibly so
  const Survey paired = mean_of(surveys, kPaired);
  EXPECT_GT(paired.pairs, 60);
  EXPECT_LE(paired.wrong, 0.03 * paired.pairs);
  EXPECT_LT(paired.bases.rmse_m, 0.9);
}

TEST(PortSurvey, TwentyFourSurveysLong) {
  const std::vector<SimulatedSurvey> surveys = simulate_all(24);
  double reckoned = 0.0;
  for (const SimulatedSurvey& survey : surveys) reckoned += dead_reckoning_rmse(survey) / 24.0;
  std::printf("dead reckoning: %.2f m\n", reckoned);
  const Survey running = mean_of(surveys, kRunning);
  EXPECT_GT(running.bases.joint_per_dof, 0.8);
  EXPECT_LT(running.bases.joint_per_dof, 1.25);
  EXPECT_LT(running.bases.position, 3.5);
  EXPECT_LT(running.bases.heading, 2.0);
  EXPECT_LT(running.bases.rmse_m, 0.6);
  EXPECT_GT(reckoned, 4.0 * running.bases.rmse_m);
  const Survey recursive = mean_of(surveys, kRecursiveRunning);
  EXPECT_NEAR(recursive.bases.rmse_m, running.bases.rmse_m, 1e-3);
  const Survey paired = mean_of(surveys, kPaired);
  EXPECT_LE(paired.wrong, 0.02 * paired.pairs);
  EXPECT_LT(paired.bases.rmse_m, 0.8);
  const Survey chained = mean_of(surveys, kNoLandmarks);
  EXPECT_LT(chained.bases.joint_per_dof, 1.25);
  const Survey walk = mean_of(surveys, kMeanWalk);
  EXPECT_LT(walk.bases.joint_per_dof, 1.3);
  EXPECT_GT(mean_of(surveys, kConstant).bases.joint_per_dof, 5.0);  // a drift that is not modelled
  EXPECT_GT(mean_of(surveys, kMeanConstant).bases.joint_per_dof, 1.5);
  EXPECT_GT(mean_of(surveys, kFirst).bases.joint_per_dof, 10.0);
  static_cast<void>(mean_of(surveys, kNone));
}

}  // namespace
}  // namespace ssjs
