// The sonar loop (docs/scenarios.md) with the augmented EKF, against its truth.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "pipeline/scenario_run.hpp"

namespace ssjs {
namespace {

constexpr int kSeeds = 20;

/// Root mean square of the position errors per component, m.
struct LoopErrors {
  double all_m = 0.0, quoted_m = 0.0, worst_m = 0.0;
  int duplicates = 0, wrong_pairs = 0, landmarks = 0;
};

LoopErrors measure(std::uint64_t seed, AssociationMethod association) {
  const Scenario scenario = built_in_scenario("aekf-loop", seed);
  const SimulatedMission mission = simulate(scenario.world, scenario.config, seed);
  SlamConfig config = testing::matching_config(scenario.config);
  config.method = Method::kAugmentedEkf;
  config.association.method = association;
  SlamPipeline pipeline(config, seed);
  LoopErrors errors;
  for (const Event& event : mission.events) {
    const StepReport step = pipeline.feed(event);
    if (step.scan) errors.wrong_pairs += step.scan->wrong_pairs;
  }
  static_cast<void>(pipeline.finish());
  std::set<std::int64_t> seen;
  double all = 0.0, quoted = 0.0;
  int quoted_landmarks = 0;
  for (const LandmarkEstimate& landmark : pipeline.world().landmarks) {
    const std::int64_t id = *landmark.landmark.source_id;
    if (!seen.insert(id).second) ++errors.duplicates;
    const double squared = (landmark.position.mean - mission.world.landmarks_m.col(static_cast<Eigen::Index>(id))).squaredNorm() / 2.0;
    all += squared;
    if (id < kAekfLoopQuoted) {
      quoted += squared;
      ++quoted_landmarks;
    }
  }
  EXPECT_EQ(quoted_landmarks, kAekfLoopQuoted);
  errors.landmarks = static_cast<int>(seen.size());
  errors.all_m = std::sqrt(all / errors.landmarks);
  errors.quoted_m = std::sqrt(quoted / kAekfLoopQuoted);
  return errors;
}

class AekfLoop : public ::testing::TestWithParam<AssociationMethod> {};

TEST_P(AekfLoop, LandmarksOfTwentySeedsLong) {
  LoopErrors sum;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const LoopErrors errors = measure(static_cast<std::uint64_t>(seed), GetParam());
    sum.all_m += errors.all_m / kSeeds;
    sum.quoted_m += errors.quoted_m / kSeeds;
    sum.worst_m = std::max(sum.worst_m, errors.all_m);
    sum.duplicates += errors.duplicates;
    sum.wrong_pairs += errors.wrong_pairs;
    EXPECT_EQ(errors.landmarks, 54) << "seed " << seed;
  }
  RecordProperty("landmark_rms_m", std::to_string(sum.all_m));
  RecordProperty("landmark_rms_worst_seed_m", std::to_string(sum.worst_m));
  RecordProperty("quoted_landmark_rms_m", std::to_string(sum.quoted_m));
  RecordProperty("wrong_pairs", sum.wrong_pairs);
  EXPECT_LE(sum.all_m, 0.45);
  EXPECT_LE(sum.quoted_m, 0.45);
  EXPECT_EQ(sum.duplicates, 0);
}

INSTANTIATE_TEST_SUITE_P(SonarLoop, AekfLoop, ::testing::Values(AssociationMethod::kKnown, AssociationMethod::kJointCompatibility));

}  // namespace
}  // namespace ssjs
