#include "ssjs/mapping/levelled_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/survey_run.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

/// Two lines and one across, asynchronous sensors that lose samples.
struct Mission {
  SurveyWorldConfig world;
  AuvSimulationConfig simulation;
};

Mission asynchronous_mission() {
  Mission mission;
  mission.world.lines = 2;
  mission.world.line_length_m = 90.0;
  mission.world.cross_lines = 1;
  mission.world.landmarks = 25;
  AuvSimulationConfig& config = mission.simulation;
  config.steps_per_attitude = 3;
  config.steps_per_compass = 4;
  config.steps_per_depth = 5;
  config.steps_per_altitude = 3;
  config.phase_steps = 1;
  config.sample_loss_fraction = 0.1;
  config.velocity_gap_every_s = 40.0;
  config.velocity_time_constant_s = config.seabed_time_constant_s = 1e6;  // random walks, as the filter has them
  return mission;
}

SimulatedSurvey survey_of(const Mission& mission, std::uint64_t seed) {
  return simulate_survey(survey_world(mission.world, seed), mission.simulation, seed);
}

/// Normalised error of position, attitude, velocity, seabed and both offsets (12) at the end of one map over the whole mission, and of its
/// landmarks with them.
struct FinalErrors {
  double vehicle = 0.0;
  double joint = 0.0;
  int joint_dof = 0;
  std::array<SensorStatistics, kNavigationSensors> statistics;
};

FinalErrors final_errors(const Mission& mission, std::uint64_t seed) {
  const SimulatedSurvey survey = survey_of(mission, seed);
  LevelledBuilderConfig config = matched(mission.simulation);
  never_split(config);
  LevelledBuilder builder(config);
  for (const NavigationTick& tick : survey.ticks) EXPECT_FALSE(builder.feed(tick).closed);
  FinalErrors errors;
  const VehicleVector error = vehicle_error(true_vehicle(survey.truth.back(), survey.truth.front()), builder.filter().vehicle());
  errors.vehicle = normalized_squared_error(error.head<12>(), builder.filter().vehicle_covariance().topLeftCorner<12, 12>());
  for (std::size_t i = 0; i < kNavigationSensors; ++i) errors.statistics[i] = builder.statistics(static_cast<NavigationSensor>(i));
  const LevelledSubmap map = *builder.finish("end");
  errors.joint = nees(map_error(map, survey), map.covariance, map.mean.size());
  errors.joint_dof = static_cast<int>(map.mean.size());
  return errors;
}

void expect_consistent(const Mission& mission, int runs, double probability) {
  double vehicle = 0.0, joint = 0.0;
  int joint_dof = 0;
  std::array<SensorStatistics, kNavigationSensors> sums{};
  for (int seed = 1; seed <= runs; ++seed) {
    const FinalErrors errors = final_errors(mission, static_cast<std::uint64_t>(seed));
    vehicle += errors.vehicle / runs;
    joint += errors.joint;
    joint_dof += errors.joint_dof;
    for (std::size_t i = 0; i < kNavigationSensors; ++i) {
      sums[i].nis_sum += errors.statistics[i].nis_sum;
      sums[i].dof += errors.statistics[i].dof;
      sums[i].refused += errors.statistics[i].refused;
      sums[i].used += errors.statistics[i].used;
    }
  }
  const Band band = mean_band(12, runs, probability);
  EXPECT_GT(vehicle, band.lower);
  EXPECT_LT(vehicle, band.upper);
  const Band joint_band = mean_band(static_cast<double>(joint_dof), 1, probability);
  EXPECT_GT(joint, joint_band.lower);
  EXPECT_LT(joint, joint_band.upper);
  std::printf("vehicle NEES %.2f of 12 in [%.2f, %.2f], joint NEES per dof %.3f over %d\n", vehicle, band.lower, band.upper,
              joint / joint_dof, joint_dof);
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    if (sums[i].dof == 0) continue;  // fixes, of which there is none, and the gyro, an input
    std::printf("  sensor %zu: NIS per dof %.3f, used %d, refused %d\n", i, sums[i].nis_sum / sums[i].dof, sums[i].used, sums[i].refused);
    EXPECT_NEAR(sums[i].nis_sum / sums[i].dof, 1.0, i == 5 ? 0.35 : 0.05) << "sensor " << i;
    EXPECT_LE(sums[i].refused, 2 + sums[i].used / 500) << "sensor " << i;
  }
}

TEST(LevelledBuilder, A15_ConsistentWithAsynchronousSensorsAndDropouts) { expect_consistent(asynchronous_mission(), 6, 0.999); }

TEST(LevelledBuilder, A15_ConsistentOver50RunsLong) { expect_consistent(asynchronous_mission(), 50, 0.95); }

TEST(LevelledBuilder, A13_FlatBottomIsConsistentLong) {
  Mission mission = asynchronous_mission();
  mission.simulation.side_scan.form = SideScanForm::kFlatBottom;
  mission.simulation.side_scan.flat_bottom_sigma_m = mission.world.landmark_height_sigma_m;
  mission.simulation.motion.seabed_walk_m_sqrt_s = 0.002;  // flat: what the landmarks stand on is what the altimeter sees
  expect_consistent(mission, 50, 0.99);
}

/// The velocity log is out for a minute: errors in position and heading stay inside three sigma, the uncertainty grows and comes back.
void expect_bounded_outage(int runs) {
  Mission mission = asynchronous_mission();
  mission.world.landmarks = 0;  // nothing but dead reckoning
  mission.simulation.velocity_outages = {{40.0, 100.0}};
  int inside = 0, total = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    const SimulatedSurvey survey = survey_of(mission, static_cast<std::uint64_t>(100 + seed));
    LevelledBuilderConfig config = matched(mission.simulation);
    never_split(config);
    LevelledBuilder builder(config);
    double before = 0.0, during = 0.0;
    for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
      (void)builder.feed(survey.ticks[i]);
      const double time_s = survey.ticks[i].time_s;
      const VehicleMatrix P = builder.filter().vehicle_covariance();
      const VehicleVector error = vehicle_error(true_vehicle(survey.truth[i], survey.truth.front()), builder.filter().vehicle());
      if (time_s < 40.0) before = std::sqrt(P(0, 0) + P(1, 1));
      if (time_s < 40.0 || time_s >= 130.0) continue;
      if (time_s < 100.0) during = std::sqrt(P(0, 0) + P(1, 1));
      for (const Eigen::Index component : {0, 1, 2, 5}) {
        ++total;
        const double sigmas = std::abs(error(component)) / std::sqrt(P(component, component));
        inside += sigmas <= 3.0 ? 1 : 0;
        EXPECT_LT(sigmas, 4.5) << "seed " << seed << ", component " << component << ", " << time_s << " s";
      }
    }
    EXPECT_GT(during, 5.0 * before);
  }
  std::printf("inside three sigma: %.4f of the time\n", static_cast<double>(inside) / total);
  EXPECT_GE(inside, 0.9973 * total);
}

TEST(LevelledBuilder, A10_AMinuteWithoutVelocityStaysInsideThreeSigma) { expect_bounded_outage(4); }
TEST(LevelledBuilder, A10_AMinuteWithoutVelocityStaysInsideThreeSigmaLong) { expect_bounded_outage(50); }

/// Normalised errors of the factors that a survey's maps are to the global level.
struct FactorCheck {
  int maps = 0;
  double link = 0.0, with_offsets = 0.0, joint = 0.0;
  int joint_dof = 0;
};

FactorCheck factor_check(const Mission& mission, double length_m, int runs) {
  FactorCheck check;
  for (int seed = 1; seed <= runs; ++seed) {
    const SimulatedSurvey survey = survey_of(mission, static_cast<std::uint64_t>(seed));
    LevelledBuilderConfig config = matched(mission.simulation);
    split_every(config, length_m);
    for (const LevelledSubmap& map : build_maps(survey, config)) {
      if (map.closed_because == "end") continue;  // as short as it happens to be
      EXPECT_EQ(map.compass, CompassPorts::kBorders);
      const Eigen::VectorXd error = map_error(map, survey);
      ++check.maps;
      check.link += nees(error, map.covariance, 3);
      check.with_offsets += nees(error, map.covariance, 5);
      check.joint += nees(error, map.covariance, map.mean.size());
      check.joint_dof += static_cast<int>(map.mean.size());
    }
  }
  std::printf("%d maps: link NEES %.2f of 3, with offsets %.2f of 5, all per dof %.3f\n", check.maps, check.link / check.maps,
              check.with_offsets / check.maps, check.joint / check.joint_dof);
  return check;
}

void expect_consistent(const FactorCheck& check, double probability) {
  const Band link = mean_band(3, check.maps, probability);
  const Band with_offsets = mean_band(5, check.maps, probability);
  EXPECT_GT(check.link / check.maps, link.lower);
  EXPECT_LT(check.link / check.maps, link.upper);
  EXPECT_GT(check.with_offsets / check.maps, with_offsets.lower);
  EXPECT_LT(check.with_offsets / check.maps, with_offsets.upper);
  EXPECT_NEAR(check.joint / check.joint_dof, 1.0, 4.0 * std::sqrt(2.0 / check.joint_dof));
}

TEST(LevelledBuilder, A17_MapsAreConsistentFactors) {
  const FactorCheck check = factor_check(Mission{}, 50.0, 2);
  EXPECT_GT(check.maps, 40);
  expect_consistent(check, 0.999);
}

TEST(LevelledBuilder, A17_MapsAreConsistentFactorsLong) {
  const FactorCheck check = factor_check(Mission{}, 50.0, 24);
  EXPECT_GT(check.maps, 500);
  expect_consistent(check, 0.99);
}

TEST(LevelledBuilder, A4_RatesAsStatesAreConsistentWithoutAGyroLong) {
  Mission mission;
  mission.simulation.motion.drive = RotationDrive::kRates;
  const FactorCheck check = factor_check(mission, 50.0, 6);
  EXPECT_LT(check.link / check.maps, 4.0);
  EXPECT_LT(check.with_offsets / check.maps, 6.5);
}

TEST(LevelledBuilder, A4_TurnsAsNoiseAreConsistentWithoutAGyroLong) {
  Mission mission;
  mission.simulation.motion.drive = RotationDrive::kConstantAttitude;
  const FactorCheck check = factor_check(mission, 50.0, 6);
  EXPECT_LT(check.link / check.maps, 4.0);
  EXPECT_LT(check.with_offsets / check.maps, 6.5);
}

TEST(LevelledBuilder, A17_EverySampleIsInOneMapAndBordersMeet) {
  const SimulatedSurvey survey = survey_of(Mission{}, 3);
  LevelledBuilderConfig config = matched(Mission{}.simulation);
  const std::vector<LevelledSubmap> maps = build_maps(survey, config);
  ASSERT_GT(maps.size(), 5U);
  std::size_t sightings = 0;
  for (const NavigationTick& tick : survey.ticks) sightings += tick.sightings.size();
  int seen = 0;
  for (std::size_t k = 0; k < maps.size(); ++k) {
    EXPECT_EQ(maps[k].index, static_cast<int>(k));
    if (k > 0) {
      EXPECT_EQ(maps[k].start_time_s, maps[k - 1].end_time_s);
    }
    // closes with a velocity fix
    const auto tick = static_cast<std::size_t>(std::lround(maps[k].end_time_s / 0.1));
    if (k + 1 < maps.size()) {
      EXPECT_TRUE(survey.ticks[tick].velocity && survey.ticks[tick].velocity->bottom_lock);
    }
    for (const MapLandmark& landmark : maps[k].landmarks) seen += landmark.times_seen;
  }
  EXPECT_EQ(static_cast<std::size_t>(seen), sightings);  // known identities, matched noise and a wide gate: nothing is refused in this run
}

TEST(LevelledBuilder, A17_WaitsForTheVelocityLogToClose) {
  Mission mission;
  mission.simulation.velocity_outages = {{20.0, 60.0}};
  const SimulatedSurvey survey = survey_of(mission, 5);
  LevelledBuilderConfig config = matched(mission.simulation);
  split_every(config, 40.0);
  const std::vector<LevelledSubmap> maps = build_maps(survey, config);
  EXPECT_GE(maps[0].end_time_s, 60.0);
  EXPECT_LT(maps[0].end_time_s, 66.0);
  EXPECT_EQ(maps[0].closed_because, "distance");
}

TEST(LevelledBuilder, A17_ACompassThatJumpsIsRefusedUntilTheNextMap) {
  SimulatedSurvey survey = survey_of(asynchronous_mission(), 7);
  for (std::size_t i = 300; i < survey.ticks.size(); ++i) {
    if (survey.ticks[i].compass_rad) *survey.ticks[i].compass_rad = wrap_angle(*survey.ticks[i].compass_rad + 1.0);
    survey.truth[i].compass_offset_rad = wrap_angle(survey.truth[i].compass_offset_rad + 1.0);
  }
  LevelledBuilderConfig config = matched(asynchronous_mission().simulation);
  split_every(config, 60.0);
  LevelledBuilder builder(config);
  int refused_in_first = 0, refused_later = 0;
  double heading_error = 0.0;
  for (std::size_t i = 0; i < survey.ticks.size(); ++i) {
    const TickResult result = builder.feed(survey.ticks[i]);
    if (i >= 300 && builder.index() == 0) refused_in_first += result.refused;
    if (builder.index() > 0) {
      refused_later += result.refused;
      const VehicleVector truth = true_vehicle(survey.truth[i], truth_at(survey, builder.map_start_s()));
      heading_error = std::max(heading_error, std::abs(vehicle_error(truth, builder.filter().vehicle())(5)));
    }
  }
  EXPECT_GT(refused_in_first, 10);
  EXPECT_LE(refused_later, 3);
  EXPECT_GE(builder.index(), 2);
  EXPECT_LT(heading_error, 0.05);
}

TEST(LevelledBuilder, A17_AVehicleWithoutVelocityLogClosesItsMaps) {
  Mission mission = asynchronous_mission();
  mission.simulation.velocity_loss_fraction = 0.999;
  const SimulatedSurvey survey = survey_of(mission, 8);
  LevelledBuilderConfig config = matched(mission.simulation);
  split_every(config, 60.0);
  config.split.needs_velocity_fix = false;
  EXPECT_GE(build_maps(survey, config).size(), 3U);
}

TEST(LevelledBuilder, A18_UnconditionedStepsStayAsFiltered) {
  const SimulatedSurvey survey = survey_of(asynchronous_mission(), 2);
  LevelledBuilderConfig config = matched(asynchronous_mission().simulation);
  never_split(config);
  const LevelledSubmap conditioned = build_maps(survey, config).front();
  config.condition_trajectory = false;
  const LevelledSubmap filtered = build_maps(survey, config).front();
  EXPECT_EQ(filtered.mean, conditioned.mean);
  EXPECT_EQ(filtered.covariance, conditioned.covariance);
  ASSERT_EQ(filtered.steps.size(), conditioned.steps.size());
  for (std::size_t i = 0; i < filtered.steps.size(); ++i) {
    EXPECT_EQ(filtered.steps[i].time_s, conditioned.steps[i].time_s);
    const Matrix6d& smoothed = conditioned.steps[i].covariance;
    EXPECT_LE(smoothed.trace(), filtered.steps[i].covariance.trace() * (1.0 + 1e-9));
    EXPECT_GE(smoothed.diagonal().minCoeff(), -1e-12);
    EXPECT_EQ(filtered.steps[i].conditional_covariance, filtered.steps[i].covariance);
    EXPECT_EQ(filtered.steps[i].gain.norm(), 0.0);
  }
}

/// Gyro bias, scale and yaw of the velocity log, each drawn anew for every run from the prior of the filter; (18, 5) vehicle states at the
/// end.
void expect_calibrated(int runs, double probability) {
  Mission mission = asynchronous_mission();
  double calibration = 0.0, vehicle = 0.0, without = 0.0;
  Rng draw(5);
  for (int seed = 1; seed <= runs; ++seed) {
    LevelledBuilderConfig config = matched(mission.simulation);
    never_split(config);
    config.start.gyro_bias_sigma_rad_s = 2e-4;
    config.start.log_scale_sigma = 0.01;
    config.start.log_yaw_sigma_rad = 0.02;
    AuvSimulationConfig simulation = mission.simulation;
    for (Eigen::Index i = 0; i < 3; ++i) simulation.gyro_bias_rad_s(i) = draw.normal(2e-4);
    simulation.velocity_log_scale = draw.normal(0.01);
    simulation.velocity_log_yaw_rad = draw.normal(0.02);
    const auto stream = static_cast<std::uint64_t>(seed);
    const SimulatedSurvey survey = simulate_survey(survey_world(mission.world, stream), simulation, stream);
    LevelledBuilder builder(config);
    LevelledBuilderConfig uncalibrated = config;
    uncalibrated.start = {};
    LevelledBuilder plain(uncalibrated);
    for (const NavigationTick& tick : survey.ticks) {
      (void)builder.feed(tick);
      (void)plain.feed(tick);
    }
    VehicleVector truth = true_vehicle(survey.truth.back(), survey.truth.front());
    truth.tail<5>() << simulation.gyro_bias_rad_s, simulation.velocity_log_scale, simulation.velocity_log_yaw_rad;
    const VehicleVector error = vehicle_error(truth, builder.filter().vehicle());
    const VehicleMatrix P = builder.filter().vehicle_covariance();
    calibration += normalized_squared_error(error.tail<5>(), P.bottomRightCorner<5, 5>()) / runs;
    vehicle += normalized_squared_error(error.head<12>(), P.topLeftCorner<12, 12>()) / runs;
    without += normalized_squared_error(vehicle_error(truth, plain.filter().vehicle()).head<12>(),
                                        plain.filter().vehicle_covariance().topLeftCorner<12, 12>()) /
               runs;
  }
  std::printf("calibration NEES %.2f of 5, vehicle NEES %.2f of 12, without these states %.1f\n", calibration, vehicle, without);
  const Band calibration_band = mean_band(5, runs, probability);
  EXPECT_GT(calibration, calibration_band.lower);
  EXPECT_LT(calibration, calibration_band.upper);
  const Band vehicle_band = mean_band(12, runs, probability);
  EXPECT_GT(vehicle, vehicle_band.lower);
  EXPECT_LT(vehicle, vehicle_band.upper);
  EXPECT_GT(without, 2.0 * vehicle);
}

TEST(LevelledBuilder, A10_CalibrationAsStatesIsConsistent) { expect_calibrated(6, 0.999); }
TEST(LevelledBuilder, A10_CalibrationAsStatesIsConsistentLong) { expect_calibrated(50, 0.99); }

TEST(LevelledBuilder, A7_OffsetOfALateCompassKnowsItsDriftSinceTheStart) {
  LevelledBuilderConfig config;
  LevelledBuilder builder(config);
  NavigationTick tick;
  tick.gyro_rad_s = Eigen::Vector3d::Zero();
  tick.roll_pitch_rad = Eigen::Vector2d::Zero();
  (void)builder.feed(tick);
  tick.time_s = 10.0;
  tick.compass_rad = 2.0;
  (void)builder.feed(tick);
  const VehicleMatrix P = builder.filter().vehicle_covariance();
  const double sigma = config.compass.sigma_rad;
  const double walk = config.motion.compass_walk_rad_sqrt_s;
  EXPECT_NEAR(builder.filter().vehicle()(10), 2.0, 1e-9);
  EXPECT_NEAR(builder.filter().vehicle()(11), 2.0, 1e-9);
  EXPECT_NEAR(P(10, 10) - P(5, 5), sigma * sigma, 1e-12);
  EXPECT_NEAR(P(10, 5), -P(5, 5), 1e-12);
  EXPECT_NEAR(P(11, 11) - P(10, 10), 10.0 * walk * walk, 1e-12);
}

TEST(LevelledBuilder, A19_MeanOfAnUncalibratedCompass) {
  Mission mission = asynchronous_mission();
  const SimulatedSurvey survey = survey_of(mission, 4);
  LevelledBuilderConfig config = matched(mission.simulation);
  config.compass_use = CompassUse::kMean;
  split_every(config, 50.0);
  for (const LevelledSubmap& map : build_maps(survey, config)) {
    EXPECT_EQ(map.compass, CompassPorts::kNone);
    if (map.end_time_s - map.start_time_s < 2.0) continue;  // the last one may end before a reading
    ASSERT_TRUE(map.compass_mean);
    const AuvTruth& start = truth_at(survey, map.start_time_s);
    const double truth = wrap_angle(truth_at(survey, map.compass_mean->time_s).compass_offset_rad + start.world_T_vehicle.rpy.z());
    EXPECT_LT(std::abs(angle_difference(map.compass_mean->offset_rad, truth)), 4.0 * std::sqrt(map.compass_mean->variance));
  }
}

TEST(LevelledBuilder, A19_TheFirstReadingTakenForExactIsOverconfident) {
  double link = 0.0;
  int maps = 0;
  const SimulatedSurvey survey = survey_of(Mission{}, 1);
  LevelledBuilderConfig config = matched(Mission{}.simulation);
  config.compass_use = CompassUse::kFirstReading;
  split_every(config, 50.0);
  for (const LevelledSubmap& map : build_maps(survey, config)) {
    if (map.closed_because == "end") continue;
    EXPECT_EQ(map.compass, CompassPorts::kNone);
    link += nees(map_error(map, survey), map.covariance, 3);
    ++maps;
  }
  std::printf("first reading taken for exact: link NEES %.1f of 3\n", link / maps);
  EXPECT_GT(link / maps, 12.0);
}

TEST(LevelledBuilder, A16_JointCompatibilityFindsTheSameLandmarks) {
  for (const SideScanForm form : {SideScanForm::kPoint, SideScanForm::kFlatBottom}) {
    Mission mission = asynchronous_mission();
    mission.simulation.side_scan.form = form;
    const SimulatedSurvey survey = survey_of(mission, 9);
    LevelledBuilderConfig config = matched(mission.simulation);
    never_split(config);
    const LevelledSubmap known = build_maps(survey, config).front();
    config.association.method = AssociationMethod::kJointCompatibility;
    LevelledBuilder builder(config);
    int wrong = 0, paired = 0;
    for (const NavigationTick& tick : survey.ticks) {
      const TickResult result = builder.feed(tick);
      wrong += result.wrong_pairs;
      paired += result.paired;
    }
    EXPECT_GT(paired, 5);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(builder.finish("end")->landmark_count(), known.landmark_count());
  }
}

TEST(LevelledBuilder, GatesRefuseAnOutlierOfOneSensorAlone) {
  const SimulatedSurvey survey = survey_of(asynchronous_mission(), 6);
  LevelledBuilderConfig config = matched(asynchronous_mission().simulation);
  never_split(config);
  LevelledBuilder builder(config);
  std::size_t i = 0;
  for (; i < 300; ++i) (void)builder.feed(survey.ticks[i]);
  const int refused = builder.statistics(NavigationSensor::kDepth).refused;
  NavigationTick tick;
  tick.time_s = survey.ticks[i].time_s;
  tick.gyro_rad_s = survey.ticks[i].gyro_rad_s;
  tick.depth_m = 40.0;
  tick.compass_rad =
      survey.ticks[i - 1].compass_rad.value_or(wrap_angle(survey.truth[i].world_T_vehicle.rpy.z() + survey.truth[i].compass_offset_rad));
  const TickResult result = builder.feed(tick);
  EXPECT_EQ(result.refused, 1);
  EXPECT_EQ(result.update.dof, 1);
  EXPECT_EQ(builder.statistics(NavigationSensor::kDepth).refused, refused + 1);
}

TEST(LevelledBuilder, SaysWhatItCannotTake) {
  LevelledBuilderConfig config;
  config.side_scan.across_sigma_m = -1.0;
  EXPECT_THROW(LevelledBuilder{config}, InvalidArgument);
  LevelledBuilder builder(LevelledBuilderConfig{});
  EXPECT_FALSE(builder.finish("end"));
  NavigationTick tick;
  tick.time_s = 5.0;
  (void)builder.feed(tick);
  tick.time_s = 4.0;
  EXPECT_THROW((void)builder.feed(tick), InvalidArgument);
  tick.time_s = 6.0;
  tick.depth_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)builder.feed(tick), InvalidArgument);
}

/// A straight line over landmarks every 2 m; sightings and velocities never share a tick.
TEST(LevelledBuilder, A17_AFullMapIsClosedByTheNextVelocity) {
  LevelledBuilderConfig config;
  config.association.method = AssociationMethod::kKnown;
  config.split.policy = {5, std::nullopt, std::nullopt, std::nullopt, std::nullopt, 2};
  config.split.longest_m = 1e6;
  LevelledBuilder builder(config);
  std::vector<LevelledSubmap> maps;
  for (int i = 0; i < 600; ++i) {
    NavigationTick tick;
    tick.time_s = 0.1 * i;
    tick.gyro_rad_s = Eigen::Vector3d::Zero();
    tick.roll_pitch_rad = Eigen::Vector2d::Zero();
    tick.compass_rad = 0.3;
    tick.depth_m = 12.0;
    tick.altitude_m = 4.0;
    if (i % 2 == 0) tick.velocity = VelocitySample{{1.5, 0.0, 0.0}, true, std::nullopt};
    if (i % 14 == 7) tick.sightings.push_back({{0.0, 10.0, 4.0}, std::nullopt, i});
    TickResult result = builder.feed(tick);
    if (result.closed) maps.push_back(std::move(*result.closed));
  }
  ASSERT_GT(maps.size(), 4U);
  for (const LevelledSubmap& map : maps) {
    EXPECT_EQ(map.closed_because, "landmarks");
    EXPECT_EQ(map.landmark_count(), 6);  // one too many came without a velocity
    ASSERT_EQ(map.seen_s.size(), 6U);
    EXPECT_EQ(map.times_seen_s(5).size(), 1U);
    EXPECT_NEAR(map.times_seen_s(5).front(), map.end_time_s, 0.15);
  }
}

}  // namespace
}  // namespace ssjs
