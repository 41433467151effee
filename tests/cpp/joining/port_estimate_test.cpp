#include "ssjs/joining/port_estimate.hpp"

#include <gtest/gtest.h>

#include <set>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/evaluation/consistency.hpp"

namespace ssjs {
namespace {

PortJoinerConfig known() {
  PortJoinerConfig config;
  config.association = AssociationMethod::kKnown;
  return config;
}

/// Map k with a step whose x, y, z is that of its first landmark: the landmark's own row of K and C says what the step must become.
void add_step_at_first_landmark(LevelledSubmap& map, Eigen::Index entries) {
  LevelledStep step;
  step.time_s = map.start_time_s;
  const Eigen::Index row = map.landmark_offset(0);
  step.base_T_vehicle.head<3>() = map.mean.segment<3>(row);
  step.base_T_vehicle(5) = 0.3;
  const Eigen::MatrixXd lead = map.covariance.topLeftCorner(entries, entries);
  step.gain.setZero(6, entries);
  step.gain.topRows<3>() = map.covariance.block(row, 0, 3, entries) * lead.inverse();
  step.covariance.topLeftCorner<3, 3>() = map.covariance.block<3, 3>(row, row);
  step.conditional_covariance.topLeftCorner<3, 3>() =
      map.covariance.block<3, 3>(row, row) - step.gain.topRows<3>() * map.covariance.block(0, row, entries, 3);
  map.steps.push_back(step);
}

TEST(PortEstimate, P14_P15_AStepFollowsItsMapAsALandmarkThere) {
  Rng rng(31);
  const testing::LevelledWorld world = testing::survey_world(rng);
  PortJoiner joiner(known());
  for (LevelledSubmap map : testing::survey_maps(world, {}, CompassPorts::kBorders, rng)) {
    if (map.landmark_count() > 1) {
      add_step_at_first_landmark(map, map.mean.size());  // follows the whole state, the landmark itself included: nothing is left
      add_step_at_first_landmark(map, 5);                // follows exit and compass
    }
    static_cast<void>(joiner.take(map));
  }
  int compared = 0;
  int tied = 0;
  for (const PortMap& map : joiner.maps()) {
    if (map.submap.steps.empty()) continue;
    const std::vector<SurveyStep> steps = steps_in_world(map, joiner.level());
    const std::vector<Sighting> first{{&map, 0}};
    const std::vector<Unknown> unknowns = unknowns_of(first);
    const PlacedSightings placed = place_sightings(first, unknowns, joiner.level().values());
    const Eigen::MatrixXd P = placed.J * joiner.level().covariance(unknowns) * placed.J.transpose() + placed.noise;
    EXPECT_LT((steps[0].global_T_vehicle.head<3>() - placed.mean).norm(), 1e-7) << "map " << map.base();
    EXPECT_LT((steps[0].covariance.topLeftCorner<3, 3>() - P).norm(), 1e-7) << "map " << map.base();
    EXPECT_NEAR(steps[0].global_T_vehicle(5), wrap_angle(0.3 + joiner.level().values().base(map.base()).heading), 1e-12);
    ++compared;
    const bool only_borders = map.ports.size() == 3;
    if (!only_borders) ++tied;
    if (only_borders) {  // then exit and compass are all that is known of the map
      EXPECT_LT((steps[1].global_T_vehicle.head<3>() - placed.mean).norm(), 1e-7);
      EXPECT_LT((steps[1].covariance.topLeftCorner<3, 3>() - P).norm(), 1e-7);
    }
  }
  EXPECT_GT(compared, 10);
  EXPECT_GT(tied, 5);
}

TEST(PortEstimate, P13_LandmarksAreListedOnceAndTheirErrorsAreAsLargeAsTheyClaim) {
  double normalized = 0.0;
  int count = 0;
  double joint = 0.0;
  Eigen::Index joint_dof = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Rng rng(400 + seed);
    const testing::LevelledWorld world = testing::survey_world(rng);
    PortJoiner joiner(known());
    std::set<std::int64_t> seen;
    for (const LevelledSubmap& map : testing::survey_maps(world, {}, CompassPorts::kBorders, rng)) {
      for (const MapLandmark& landmark : map.landmarks) seen.insert(*landmark.source_id);
      static_cast<void>(joiner.take(map));
    }
    const std::vector<SurveyLandmark> landmarks = landmarks_in_world(joiner.maps(), joiner.level());
    ASSERT_EQ(landmarks.size(), seen.size());
    const Eigen::MatrixXd P = joint_landmark_covariance(joiner.maps(), joiner.level());
    Eigen::VectorXd errors(P.rows());
    ASSERT_EQ(P.rows(), static_cast<Eigen::Index>(3 * landmarks.size()));
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(3 * i);
      errors.segment<3>(at) = landmarks[i].position - world.landmarks[static_cast<std::size_t>(*landmarks[i].landmark.source_id)];
      EXPECT_LT((P.block<3, 3>(at, at) - landmarks[i].covariance).norm(), 1e-9);
    }
    joint += normalized_squared_error(errors, P);
    joint_dof += errors.size();
    for (const SurveyLandmark& landmark : landmarks) {
      const Eigen::Vector3d error = landmark.position - world.landmarks[static_cast<std::size_t>(*landmark.landmark.source_id)];
      normalized += error.dot(landmark.covariance.ldlt().solve(error)) / 3.0;
      ++count;
      EXPECT_EQ(landmark.landmark.tracks.size(), landmark.maps.size());
    }
  }
  // the landmarks of one survey share its turn and place: 12 surveys, not hundreds of samples
  EXPECT_GT(normalized / count, 0.6);
  EXPECT_LT(normalized / count, 1.5);
  const Band band = mean_band(static_cast<double>(joint_dof), 1);
  EXPECT_GT(joint, band.lower);
  EXPECT_LT(joint, band.upper);
}

TEST(PortEstimate, AGainThatDoesNotFitIsRefused) {
  Rng rng(32);
  const testing::LevelledWorld world = testing::survey_world(rng);
  PortJoiner joiner(known());
  LevelledSubmap map = testing::survey_maps(world, {}, CompassPorts::kBorders, rng).front();
  map.steps.emplace_back();
  map.steps.back().gain.setZero(6, 2);
  static_cast<void>(joiner.take(map));
  EXPECT_THROW(static_cast<void>(steps_in_world(joiner.maps().front(), joiner.level())), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
