#include "ssjs/simulation/auv_survey.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

TEST(AuvSurvey, IsTheSurveyOfTheDefaults) {
  const SurveyWorld world = survey_world({}, 1);
  EXPECT_EQ(world.landmarks_m.cols(), 60);
  const SimulatedSurvey survey = simulate_survey(world, {}, 1);
  ASSERT_EQ(survey.ticks.size(), survey.truth.size());
  double length_m = 0.0, fastest_turn = 0.0;
  for (std::size_t i = 1; i < survey.truth.size(); ++i) {
    const Eigen::Vector3d step = survey.truth[i].world_T_vehicle.translation - survey.truth[i - 1].world_T_vehicle.translation;
    length_m += step.norm();
    fastest_turn = std::max(fastest_turn, std::abs(survey.truth[i].rates_rad_s.z()));
    EXPECT_NEAR(survey.truth[i].world_T_vehicle.translation.z(), 12.0, 3.0);
    EXPECT_GT(survey.truth[i].seabed_m, survey.truth[i].world_T_vehicle.translation.z());
  }
  // five lines of 120 m and three of 100 m, with the legs between them: about 1.17 km and 13 minutes at 1.5 m/s
  EXPECT_NEAR(length_m, 1170.0, 120.0);
  EXPECT_NEAR(survey.truth.back().time_s, 775.0, 80.0);
  EXPECT_NEAR(fastest_turn, 0.1396, 0.01);
}

TEST(AuvSurvey, RatesOfTheSensors) {
  AuvSimulationConfig config;
  config.steps_per_compass = 3;
  config.phase_steps = 1;
  const SimulatedSurvey survey = simulate_survey(survey_world({}, 2), config, 2);
  int velocity = 0, locked = 0;
  for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
    const NavigationTick& tick = survey.ticks[i];
    EXPECT_DOUBLE_EQ(tick.time_s, survey.truth[i].time_s);
    EXPECT_TRUE(tick.gyro_rad_s && tick.roll_pitch_rad);
    EXPECT_EQ(tick.compass_rad.has_value(), i % 3 == 1);
    EXPECT_EQ(tick.altitude_m.has_value(), i % 2 == 1);
    EXPECT_EQ(tick.velocity.has_value(), i % 2 == 0);
    velocity += tick.velocity ? 1 : 0;
    locked += tick.velocity && tick.velocity->bottom_lock ? 1 : 0;
  }
  const double lost = 1.0 - static_cast<double>(locked) / velocity;
  EXPECT_GT(lost, 0.05);
  EXPECT_LT(lost, 0.2);
}

TEST(AuvSurvey, A23_ALandmarkIsSeenOnceAPassAbeamInTheSwath) {
  AuvSimulationConfig config;
  const SimulatedSurvey survey = simulate_survey(survey_world({}, 3), config, 3);
  std::map<std::int64_t, double> last_s;
  int sightings = 0, again = 0;
  for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
    for (const SideScanSighting& sighting : survey.ticks[i].sightings) {
      ++sightings;
      const AuvTruth& truth = survey.truth[i];
      const Eigen::Vector3d p =
          truth.world_T_vehicle.rotation().transpose() *
          (survey.world.landmarks_m.col(static_cast<Eigen::Index>(*sighting.landmark_id)) - truth.world_T_vehicle.translation);
      EXPECT_LE(p.x(), 0.0);
      EXPECT_GT(p.x(), -1.5);  // it passes sideways where the vehicle turns slowly
      EXPECT_GE(std::abs(p.y()), config.min_across_m);
      EXPECT_LE(std::abs(p.y()), config.max_across_m);
      EXPECT_LE(std::abs(truth.rates_rad_s.z()), config.max_turn_rate_rad_s);
      const auto before = last_s.find(*sighting.landmark_id);
      if (before != last_s.end()) {
        ++again;
        EXPECT_GT(truth.time_s - before->second, 1.0);
      }
      last_s[*sighting.landmark_id] = truth.time_s;
    }
  }
  EXPECT_GT(sightings, 100);
  EXPECT_GT(again, 50);
}

TEST(AuvSurvey, NoiseHasItsSigma) {
  AuvSimulationConfig config;
  const SimulatedSurvey survey = simulate_survey(survey_world({}, 4), config, 4);
  double gyro = 0.0, compass = 0.0, depth = 0.0, velocity = 0.0;
  int n = 0, velocities = 0;
  for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
    const NavigationTick& tick = survey.ticks[i];
    const AuvTruth& truth = survey.truth[i];
    gyro += (*tick.gyro_rad_s - truth.rates_rad_s).squaredNorm() / 3.0;
    compass += std::pow(angle_difference(*tick.compass_rad, truth.world_T_vehicle.rpy.z() + truth.compass_offset_rad), 2);
    depth += std::pow(*tick.depth_m - truth.world_T_vehicle.translation.z(), 2);
    ++n;
    if (!tick.velocity) continue;
    velocity += (tick.velocity->velocity_m_s - truth.velocity_m_s).squaredNorm() / 3.0;
    ++velocities;
  }
  EXPECT_NEAR(std::sqrt(gyro / n), config.motion.gyro_sigma_rad_s, 0.03 * config.motion.gyro_sigma_rad_s);
  EXPECT_NEAR(std::sqrt(compass / n), config.compass.sigma_rad, 0.03 * config.compass.sigma_rad);
  EXPECT_NEAR(std::sqrt(depth / n), config.depth.sigma_m, 0.03 * config.depth.sigma_m);
  EXPECT_NEAR(std::sqrt(velocity / velocities), config.velocity_log.sigma_m_s, 0.03 * config.velocity_log.sigma_m_s);
}

TEST(AuvSurvey, StreamsAreIndependent) {
  // more lost samples and other noise of one sensor leave the truth and the other sensors alone
  AuvSimulationConfig config;
  const SurveyWorld world = survey_world({}, 5);
  const SimulatedSurvey one = simulate_survey(world, config, 5);
  config.depth.sigma_m *= 3.0;
  config.velocity_outages = {{10.0, 20.0}};
  const SimulatedSurvey other = simulate_survey(world, config, 5);
  ASSERT_EQ(one.ticks.size(), other.ticks.size());
  for (std::size_t i = 0; i < one.ticks.size(); ++i) {
    EXPECT_EQ(one.truth[i].world_T_vehicle.vector(), other.truth[i].world_T_vehicle.vector());
    EXPECT_EQ(*one.ticks[i].gyro_rad_s, *other.ticks[i].gyro_rad_s);
    EXPECT_EQ(one.ticks[i].sightings.size(), other.ticks[i].sightings.size());
    const double time_s = other.ticks[i].time_s;
    if (other.ticks[i].velocity && time_s >= 10.0 && time_s < 20.0) {
      EXPECT_FALSE(other.ticks[i].velocity->bottom_lock);
    }
  }
}

/// Two short dives: two lines of 200 m 30 m apart and one cross line, at 12 m and at 14 m.
SurveyWorld two_dives() {
  SurveyWorldConfig lines;
  lines.lines = 2;
  lines.line_length_m = 200.0;
  lines.line_spacing_m = 30.0;
  lines.cross_lines = 1;
  lines.dives = 2;
  return survey_world(lines, 6);
}

TEST(AuvSurvey, ASecondDiveIsDeeperAfterTheSurface) {
  const SurveyWorld world = two_dives();
  // six waypoints a dive, one at the surface between them: 13, so 12 legs, of which that to the run-in is at the surface
  ASSERT_EQ(world.waypoints.size(), 13U);
  ASSERT_EQ(world.dives.size(), 12U);
  EXPECT_EQ(world.dives[4], 0);
  EXPECT_FALSE(world.dives[5].has_value());
  EXPECT_EQ(world.dives[6], 1);
  AuvSimulationConfig config;
  config.dive_step_m = 2.0;
  config.depth_gain_rad_m = 0.3;
  const SimulatedSurvey survey = simulate_survey(world, config, 6);
  double shallowest_m = 12.0;
  std::size_t at_surface = 0;
  for (std::size_t i = 0; i < survey.truth.size(); ++i) {
    const double depth_m = survey.truth[i].world_T_vehicle.translation.z();
    if (depth_m < shallowest_m) at_surface = i;
    shallowest_m = std::min(shallowest_m, depth_m);
  }
  EXPECT_NEAR(shallowest_m, config.surface_depth_m, 0.5);
  EXPECT_NEAR(survey.truth[at_surface / 2].world_T_vehicle.translation.z(), 12.0, 1.0);
  EXPECT_NEAR(survey.truth.back().world_T_vehicle.translation.z(), 14.0, 1.0);
}

TEST(AuvSurvey, EndsAfterItsDuration) {
  AuvSimulationConfig config;
  config.duration_s = 60.0;
  const SimulatedSurvey cut = simulate_survey(two_dives(), config, 6);
  EXPECT_NEAR(cut.truth.back().time_s, 60.0, 1e-9);
  config.duration_s = 61.0;
  const SimulatedSurvey longer = simulate_survey(two_dives(), config, 6);
  for (std::size_t i = 0; i < cut.truth.size(); ++i)
    EXPECT_EQ(cut.truth[i].world_T_vehicle.vector(), longer.truth[i].world_T_vehicle.vector());
}

TEST(AuvSurvey, A24_FalseSightingsAndTideComeOnTopOfAnUnchangedSurvey) {
  AuvSimulationConfig config;
  const SurveyWorld world = survey_world({}, 6);
  const SimulatedSurvey plain = simulate_survey(world, config, 6);
  config.mirrored_fraction = 0.5;
  config.clutter_per_s = 0.2;
  config.tide_m = 2.0;
  config.tide_period_s = 1500.0;
  const SimulatedSurvey doubtful = simulate_survey(world, config, 6);
  ASSERT_EQ(plain.ticks.size(), doubtful.ticks.size());
  int real = 0, mirrored = 0, clutter = 0;
  double straight_s = 0.0;
  for (std::size_t i = 0; i < plain.ticks.size(); ++i) {
    const SideScanSightings& seen = plain.ticks[i].sightings;
    const SideScanSightings& all = doubtful.ticks[i].sightings;
    ASSERT_GE(all.size(), seen.size());
    for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_EQ(all[k].vehicle_p_point, seen[k].vehicle_p_point);
    for (std::size_t k = seen.size(); k < all.size(); ++k) {
      EXPECT_GE(*all[k].landmark_id, kFirstClutterId);
      bool is_mirrored = false;
      for (const SideScanSighting& of : seen) {
        is_mirrored |= of.vehicle_p_point.cwiseProduct(Eigen::Vector3d(1.0, -1.0, 1.0)) == all[k].vehicle_p_point;
      }
      (is_mirrored ? mirrored : clutter) += 1;
    }
    real += static_cast<int>(seen.size());
    straight_s += std::abs(plain.truth[i].rates_rad_s.z()) <= config.max_turn_rate_rad_s ? config.step_s : 0.0;
    const double tide_m = 2.0 * std::sin(2.0 * kPi * plain.ticks[i].time_s / 1500.0);
    EXPECT_NEAR(*doubtful.ticks[i].depth_m - *plain.ticks[i].depth_m, tide_m, 1e-9);
    EXPECT_EQ(doubtful.ticks[i].altitude_m, plain.ticks[i].altitude_m);
  }
  EXPECT_NEAR(mirrored, 0.5 * real, 4.0 * std::sqrt(0.25 * real));
  EXPECT_NEAR(clutter, 0.2 * straight_s, 4.0 * std::sqrt(0.2 * straight_s));
}

TEST(AuvSurvey, SaysWhatItCannotSimulate) {
  AuvSimulationConfig config;
  config.step_s = 0.0;
  EXPECT_THROW((void)simulate_survey(survey_world({}, 1), config, 1), InvalidArgument);
  config = {};
  config.max_across_m = 2.0;
  EXPECT_THROW((void)simulate_survey(survey_world({}, 1), config, 1), InvalidArgument);
  SurveyWorld world = survey_world({}, 1);
  world.ids.pop_back();
  EXPECT_THROW((void)simulate_survey(world, {}, 1), InvalidArgument);
  world = survey_world({}, 1);
  world.dives.pop_back();
  EXPECT_THROW((void)simulate_survey(world, {}, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
