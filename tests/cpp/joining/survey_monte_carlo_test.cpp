/// What surveys whose sensors are not as the filter takes them come to: docs/math/auv.md, "Beyond the nominal survey".
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include "joining/levelled_world.hpp"
#include "joining/survey_bases.hpp"
#include "mapping/survey_run.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {
namespace {

constexpr double kDegree = kPi / 180.0;

/// A survey, and what its filter takes it for.
struct Case {
  SurveyWorldConfig world;
  AuvSimulationConfig truth;
  LevelledBuilderConfig filter;
  PortJoinerConfig joining;
  double slope = 0.0;  ///< of the seabed towards east, deeper by so much a metre

  Case() { match(); }
  /// The filter has the simulator's models; maps of 50 m.
  void match() {
    filter = testing::matched(truth);
    testing::split_every(filter, 50.0);
    joining.association = AssociationMethod::kKnown;
  }
};

/// Means over the surveys.
struct Outcome {
  testing::BaseErrors bases;
  int pairs = 0, wrong = 0;
};

SimulatedSurvey simulate(const Case& c, std::uint64_t seed) {
  SurveyWorld world = survey_world(c.world, seed);
  if (c.slope == 0.0) return simulate_survey(world, c.truth, seed);
  const SeabedDepth seabed = [&](const Eigen::Vector2d& p) { return c.world.seabed_depth_m + c.slope * p.y(); };
  for (Eigen::Index i = 0; i < world.landmarks_m.cols(); ++i) world.landmarks_m(2, i) += c.slope * world.landmarks_m(1, i);
  return simulate_survey(world, c.truth, seed, seabed);
}

Outcome run(const char* name, const Case& c, int surveys) {
  Outcome mean;
  for (int seed = 0; seed < surveys; ++seed) {
    const SimulatedSurvey survey = simulate(c, static_cast<std::uint64_t>(seed));
    const std::vector<LevelledSubmap> maps = testing::build_maps(survey, c.filter);
    PortJoiner joiner(c.joining);
    for (const LevelledSubmap& map : maps) {
      for (const LoopAttempt& loop : joiner.take(map).loops) {
        mean.pairs += loop.pairs;
        mean.wrong += loop.wrong_pairs.value_or(0);
      }
    }
    joiner.finish();
    const testing::BaseErrors errors = testing::base_errors(joiner.level(), testing::true_bases(survey, maps));
    mean.bases.rmse_m += errors.rmse_m / surveys;
    mean.bases.joint_per_dof += errors.joint_per_dof / surveys;
    mean.bases.position += errors.position / surveys;
    mean.bases.heading += errors.heading / surveys;
  }
  std::printf("| %s | %d | %.2f | %.2f | %.2f | %.2f | %d / %d |\n", name, surveys, mean.bases.rmse_m, mean.bases.joint_per_dof,
              mean.bases.position, mean.bases.heading, mean.wrong, mean.pairs);
  std::fflush(stdout);
  return mean;
}

/// `change` alters the survey alone: the filter does not know of it.
Case unknown_to_the_filter(const std::function<void(AuvSimulationConfig&)>& change) {
  Case c;
  change(c.truth);
  return c;
}

void with_landmarks_seldom_seen(Case& c) { c.world.landmarks = 20; }

constexpr int kSurveys = 24;

TEST(SurveyMonteCarlo, NominalLong) {
  const Outcome nominal = run("nominal", Case(), kSurveys);
  EXPECT_LT(nominal.bases.joint_per_dof, 1.25);
  Case sparse;
  with_landmarks_seldom_seen(sparse);
  EXPECT_LT(run("nominal, 20 landmarks", sparse, kSurveys).bases.joint_per_dof, 1.25);
}

TEST(SurveyMonteCarlo, VehicleWithoutAGyroLong) {
  for (const RotationDrive drive : {RotationDrive::kRates, RotationDrive::kConstantAttitude}) {
    Case c;
    c.truth.motion.drive = drive;
    c.match();
    const Outcome outcome = run(drive == RotationDrive::kRates ? "no gyro, rates as states" : "no gyro, turns as noise", c, kSurveys);
    EXPECT_LT(outcome.bases.joint_per_dof, 1.25);
  }
}

TEST(SurveyMonteCarlo, GyroBiasLong) {
  for (const double bias_deg_s : {0.01, 0.1}) {
    Case c = unknown_to_the_filter([&](AuvSimulationConfig& truth) { truth.gyro_bias_rad_s.setConstant(bias_deg_s * kDegree); });
    char name[64];
    std::snprintf(name, sizeof(name), "gyro bias %.2f deg/s, unknown", bias_deg_s);
    const Outcome unknown = run(name, c, kSurveys);
    c.filter.start.gyro_bias_sigma_rad_s = bias_deg_s * kDegree;
    std::snprintf(name, sizeof(name), "gyro bias %.2f deg/s, a state of each map", bias_deg_s);
    const Outcome known = run(name, c, kSurveys);
    EXPECT_LT(known.bases.joint_per_dof, 1.3);
    if (bias_deg_s > 0.05) {
      EXPECT_GT(unknown.bases.joint_per_dof, 2.0);
    }
  }
}

TEST(SurveyMonteCarlo, VelocityLogCalibrationLong) {
  Case c = unknown_to_the_filter([](AuvSimulationConfig& truth) {
    truth.velocity_log_scale = 0.01;
    truth.velocity_log_yaw_rad = 1.0 * kDegree;
  });
  const Outcome unknown = run("velocity log 1 % long, 1 deg aside, unknown", c, kSurveys);
  c.filter.start.log_scale_sigma = 0.01;
  c.filter.start.log_yaw_sigma_rad = 1.0 * kDegree;
  const Outcome known = run("the same, states of each map", c, kSurveys);
  EXPECT_GT(unknown.bases.joint_per_dof, known.bases.joint_per_dof);
}

TEST(SurveyMonteCarlo, TideLong) {
  for (const double tide_m : {0.5, 2.0}) {
    char name[64];
    std::snprintf(name, sizeof(name), "tide %.1f m in 1500 s, unknown", tide_m);
    Case c = unknown_to_the_filter([&](AuvSimulationConfig& truth) {
      truth.tide_m = tide_m;
      truth.tide_period_s = 1500.0;
    });
    static_cast<void>(run(name, c, kSurveys));
    c.joining.association = AssociationMethod::kJointCompatibility;
    std::snprintf(name, sizeof(name), "the same, joint compatibility");
    static_cast<void>(run(name, c, kSurveys));
  }
}

TEST(SurveyMonteCarlo, SlopingBottomLong) {
  for (const double slope : {0.0, 0.02, 0.05, 0.1}) {
    Case c;
    c.truth.side_scan.form = SideScanForm::kFlatBottom;
    c.slope = slope;
    c.match();
    char name[64];
    std::snprintf(name, sizeof(name), "flat-bottom sightings, slope %.0f %%", 100.0 * slope);
    const Outcome outcome = run(name, c, kSurveys);
    if (slope == 0.0) {
      EXPECT_LT(outcome.bases.joint_per_dof, 1.25);
    }
  }
  Case c;
  c.truth.side_scan.form = SideScanForm::kFlatBottom;
  c.slope = 0.1;
  c.match();
  c.filter.side_scan.flat_bottom_sigma_m = 2.0;
  static_cast<void>(run("slope 10 %, side_scan.flat_bottom_sigma_m = 2", c, kSurveys));
}

TEST(SurveyMonteCarlo, CompassLong) {
  for (const double deviation_deg : {0.0, 1.5, 5.0}) {
    for (const CompassUse use : {CompassUse::kFilter, CompassUse::kMean}) {
      Case c = unknown_to_the_filter([&](AuvSimulationConfig& truth) { truth.compass_deviation_rad = deviation_deg * kDegree; });
      c.filter.compass_use = use;
      if (use == CompassUse::kMean) c.joining.offset_drift_rad_per_sqrt_s = c.truth.motion.compass_walk_rad_sqrt_s;
      char name[64];
      std::snprintf(name, sizeof(name), "compass deviation %.1f deg, %s", deviation_deg, use == CompassUse::kMean ? "mean" : "filter");
      const Outcome outcome = run(name, c, kSurveys);
      if (deviation_deg == 0.0) {
        EXPECT_LT(outcome.bases.joint_per_dof, 1.3);
      }
    }
  }
}

TEST(SurveyMonteCarlo, MirroredEchoesAndClutterLong) {
  for (const bool worse : {false, true}) {
    Case c = unknown_to_the_filter([&](AuvSimulationConfig& truth) {
      truth.mirrored_fraction = worse ? 0.3 : 0.1;
      truth.clutter_per_s = worse ? 0.1 : 0.02;
    });
    c.joining.association = AssociationMethod::kJointCompatibility;
    c.filter.association.method = AssociationMethod::kJointCompatibility;
    const char* name = worse ? "30 % mirrored, clutter every 10 s, joint compatibility" : "10 % mirrored, clutter every 50 s, the same";
    const Outcome outcome = run(name, c, kSurveys);
    EXPECT_LE(outcome.wrong, 0.05 * outcome.pairs);
    EXPECT_LT(outcome.bases.rmse_m, 1.0);
  }
}

}  // namespace
}  // namespace ssjs
