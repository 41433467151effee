// A step of the underwater filter takes nothing from the heap: counted, and by Eigen's own word. A whole simulated survey, not a made-up
// step: what the builder, the filter, the journal and the association of a single sighting do is all in it.
#include <gtest/gtest.h>

#include "allocation/no_malloc.hpp"
#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {
namespace {

struct Counted {
  int maps = 0;
  long steps = 0, sightings_paired = 0, remembered = 0, updated = 0;  ///< plain ones
  long taken = 0;
};

/// Plain steps of a survey after its first maps: no map ends, no landmark is new, and a ping shows one point at most where identities are
/// not known. Whether a step is plain is known afterwards only, so that each is done twice: by a builder that may allocate, and, where
/// that one says so, by one that may not.
Counted drive(const LevelledBuilderConfig& config, int warm_up_maps) {
  SurveyWorldConfig world;
  world.landmarks = 150;
  const SimulatedSurvey survey = simulate_survey(survey_world(world, 5), {}, 5);
  LevelledBuilder scout(config, StepSmoothing::kByCaller), builder(config, StepSmoothing::kByCaller);
  Counted counted;
  const auto smooth = [](LevelledBuilder& of, TickResult& result) {
    if (!result.closed) return;
    const std::vector<LevelledStep> steps = result.steps->smoothed();
    EXPECT_FALSE(steps.empty());
    of.reuse(std::move(result.steps->record));
  };
  for (const NavigationTick& tick : survey.ticks) {
    TickResult seen = scout.feed(tick);
    const bool searched = tick.sightings.size() > 1 && config.association.method != AssociationMethod::kKnown;
    const bool is_plain = !seen.closed && seen.added == 0 && !searched && counted.maps >= warm_up_maps;
    counted.maps += seen.closed ? 1 : 0;
    smooth(scout, seen);
    if (!is_plain) {
      TickResult result = builder.feed(tick);
      smooth(builder, result);
      continue;
    }
    const testing::NoMalloc forbidden;
    const TickResult result = builder.feed(tick);
    counted.taken += forbidden.taken();
    ++counted.steps;
    counted.sightings_paired += result.paired;
    counted.remembered += result.remembered ? 1 : 0;
    counted.updated += result.update.dof > 0 ? 1 : 0;
  }
  return counted;
}

class LevelledAllocation : public ::testing::TestWithParam<AssociationMethod> {};

TEST_P(LevelledAllocation, APlainStepTakesNothingFromTheHeap) {
  LevelledBuilderConfig config;
  config.association.method = GetParam();
  config.split.policy.max_distance_m = 60.0;
  const Counted counted = drive(config, 6);
  EXPECT_GT(counted.maps, 15);
  EXPECT_GT(counted.steps, 4000);
  EXPECT_GT(counted.updated, 4000);
  EXPECT_GT(counted.remembered, 400);
  EXPECT_EQ(counted.taken, 0);
}

TEST_P(LevelledAllocation, NorDoesASightingOfAKnownLandmark) {
  LevelledBuilderConfig config;  // one map for all, so that landmarks are met again in it
  config.association.method = GetParam();
  config.split.policy.max_distance_m.reset();
  config.split.policy.max_landmarks = 1000;
  config.split.longest_m = 1e6;
  config.condition_trajectory = false;
  const Counted counted = drive(config, 0);
  EXPECT_GT(counted.sightings_paired, 30);
  // the buffers that grow while the only map does are those of landmarks and of sighting times, in steps that are not plain or at twice
  // their size
  EXPECT_EQ(counted.taken, 0);
}

INSTANTIATE_TEST_SUITE_P(Association, LevelledAllocation,
                         ::testing::Values(AssociationMethod::kKnown, AssociationMethod::kJointCompatibility,
                                           AssociationMethod::kNearestNeighbour));

}  // namespace
}  // namespace ssjs
