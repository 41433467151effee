#include "ssjs/joining/augmented.hpp"

#include <gtest/gtest.h>

#include "joining/drive.hpp"
#include "pipeline/scenario_run.hpp"
#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

/// A vehicle at rest among four landmarks, seen from the origin without error.
struct Scene {
  static Feature seen(double x_m, double y_m, std::int64_t id) {
    return {{std::hypot(x_m, y_m), std::atan2(y_m, x_m)}, Eigen::Vector2d(1e-4, 1e-6).asDiagonal(), id};
  }
  static Feature fixed(int i) { return seen(5.0 * std::cos(1.5 * i), 5.0 * std::sin(1.5 * i), i); }

  SubmapBuilderConfig submap;
  ScanAssociationConfig association;
  RangeBearingConfig sensor;
  AugmentedEkfConfig config;
  double time_s = 0.0;

  Scene() {
    association.method = AssociationMethod::kKnown;
    sensor.range_sigma_m = 0.01;
    sensor.bearing_sigma_rad = 0.001;
    sensor.max_range_m = 10.0;
    config.view_window = 6;
    config.max_missed_views = 4;
  }
  [[nodiscard]] AugmentedEkfMapper mapper() const { return AugmentedEkfMapper(config, sensor, submap, association, 1); }
  void scan(AugmentedEkfMapper& mapper, const Features& more) {
    Features all{fixed(0), fixed(1), seen(0.0, 9.9, 3)};  // the last one: so that the farthest observation is 9.9 m
    all.insert(all.end(), more.begin(), more.end());
    static_cast<void>(mapper.observe(time_s += 1.0, all));
  }
  static bool holds(const AugmentedEkfMapper& mapper, std::int64_t id) {
    for (const LandmarkEstimate& landmark : mapper.world(BaseCovariance::kBorders).landmarks) {
      if (landmark.landmark.source_id == id) return true;
    }
    return false;
  }
};

TEST(AugmentedEkf, G5_AGhostLeavesAfterTheViewsItWasMissedIn) {
  Scene scene;
  AugmentedEkfMapper mapper = scene.mapper();
  scene.scan(mapper, {Scene::seen(4.0, -4.0, 99)});
  for (int missed = 1; missed <= 3; ++missed) {
    scene.scan(mapper, {});
    EXPECT_TRUE(Scene::holds(mapper, 99)) << missed;
  }
  scene.scan(mapper, {});
  EXPECT_FALSE(Scene::holds(mapper, 99));
  for (const int id : {0, 1, 3}) EXPECT_TRUE(Scene::holds(mapper, id)) << id;
}

TEST(AugmentedEkf, G5_ALandmarkSeenAgainStays) {
  Scene scene;
  AugmentedEkfMapper mapper = scene.mapper();
  for (int i = 0; i < 3; ++i) scene.scan(mapper, {Scene::seen(4.0, -4.0, 99)});  // permanent_sightings
  for (int i = 0; i < 50; ++i) scene.scan(mapper, {});
  EXPECT_TRUE(Scene::holds(mapper, 99));
}

TEST(AugmentedEkf, G5_OnlyMissesOfTheWindowCount) {
  Scene scene;
  scene.config.permanent_sightings = 100;
  AugmentedEkfMapper mapper = scene.mapper();
  for (int i = 0; i < 12; ++i) {  // every other view missed: 3 of any 6
    scene.scan(mapper, {Scene::seen(4.0, -4.0, 99)});
    scene.scan(mapper, {});
  }
  EXPECT_TRUE(Scene::holds(mapper, 99));
  for (int i = 0; i < 3; ++i) scene.scan(mapper, {});  // with the one before: 4 in a row, 5 of 6
  EXPECT_FALSE(Scene::holds(mapper, 99));
}

TEST(AugmentedEkf, G5_OutOfRangeOrOutOfTheFieldIsNotAMiss) {
  Scene scene;
  AugmentedEkfMapper mapper = scene.mapper();
  scene.scan(mapper, {Scene::seen(9.895, 0.0, 98)});  // at the end of the range: it may or may not be seen
  for (int i = 0; i < 20; ++i) scene.scan(mapper, {});
  EXPECT_TRUE(Scene::holds(mapper, 98));

  scene.config.field_of_view_rad = kPi;
  AugmentedEkfMapper half = scene.mapper();
  scene.scan(half, {Scene::seen(-4.0, 1.0, 97), Scene::seen(4.0, 1.0, 96)});
  for (int i = 0; i < 20; ++i) scene.scan(half, {});
  EXPECT_TRUE(Scene::holds(half, 97));  // behind the vehicle
  EXPECT_FALSE(Scene::holds(half, 96));
}

TEST(AugmentedEkf, PoseErrorsAreAsLargeAsTheyClaim) {
  // The pose half a minute into the sonar loop over 50 seeds: the sum of the normalised squared errors is chi-squared with 150 degrees of
  // freedom.
  constexpr int kSeeds = 50;
  double sum = 0.0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Scenario scenario = built_in_scenario("aekf-loop", static_cast<std::uint64_t>(seed));
    const SimulatedMission mission = simulate(scenario.world, scenario.config, static_cast<std::uint64_t>(seed));
    SlamConfig config = testing::matching_config(scenario.config);
    config.method = Method::kAugmentedEkf;
    SlamPipeline pipeline(config, 1);
    for (const Event& event : mission.events) {
      if (event.time_s > 30.0) break;
      static_cast<void>(pipeline.feed(event));
    }
    const GaussianSe2 vehicle = pipeline.global_T_vehicle();
    sum += normalized_squared_error(additive_difference(vehicle.mean, testing::truth_at(mission, 30.0)), vehicle.covariance);
  }
  EXPECT_GE(sum, chi_squared_quantile(0.005, 3.0 * kSeeds));
  EXPECT_LE(sum, chi_squared_quantile(0.995, 3.0 * kSeeds));
}

}  // namespace
}  // namespace ssjs
