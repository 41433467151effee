// Four hours in two dives with and without fixes at the surface: what they do to the turn of the whole map. docs/math/ports.md (P-31)
#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/pipeline/levelled_run.hpp"
#include "ssjs/simulation/auv_survey.hpp"

namespace ssjs {
namespace {

struct Errors {
  double rmse_m = 0.0, landmarks_m = 0.0, inside = 0.0;
  int fixes = 0, refused = 0;
};

/// The lines of remus-survey, with points that a perfect detector shows instead of pings.
Errors two_dives(std::uint64_t seed, bool with_fixes) {
  SurveyWorldConfig lines;
  lines.lines = 12;
  lines.line_length_m = 370.0;
  lines.line_spacing_m = 25.0;
  lines.cross_lines = 17;
  lines.cross_margin_m = 15.0;
  lines.landmark_margin_m = 12.5;
  lines.dives = 2;
  lines.landmarks = 80;
  AuvSimulationConfig vehicle;
  vehicle.dive_step_m = 2.0;
  vehicle.depth_gain_rad_m = 0.3;
  vehicle.sample_loss_fraction = 0.02;
  if (with_fixes) {
    lines.surface_start = true;
    lines.run_in_m = 150.0;
    vehicle.fix_interval_s = 1.0;
  }
  const SimulatedSurvey survey = simulate_survey(survey_world(lines, seed), vehicle, seed);
  const LevelledResult result = run_levelled_mission(LevelledConfig{}, survey.ticks);
  Errors errors;
  const auto steps = static_cast<double>(result.time_s.size());
  for (Eigen::Index i = 0; i < result.time_s.size(); ++i) {
    const Se3& truth = survey.truth[static_cast<std::size_t>(std::lround(result.time_s(i) / vehicle.step_s))].world_T_vehicle;
    const Eigen::Vector2d error = result.pose.row(i).head<2>().transpose() - truth.translation.head<2>();
    const Eigen::Array2d sigma = Eigen::Array2d(result.covariance(i, 0), result.covariance(i, 6)).sqrt();
    errors.rmse_m += error.squaredNorm() / steps;
    errors.inside += (error.array().abs() <= 3.0 * sigma).all() ? 1.0 / steps : 0.0;
  }
  errors.rmse_m = std::sqrt(errors.rmse_m);
  int count = 0;
  for (const SurveyLandmark& landmark : result.landmarks) {
    if (!landmark.landmark.source_id || landmark.maps.size() < 2) continue;
    const Eigen::Vector3d truth = survey.world.landmarks_m.col(*landmark.landmark.source_id);
    errors.landmarks_m += (landmark.position - truth).head<2>().squaredNorm();
    ++count;
  }
  errors.landmarks_m = std::sqrt(errors.landmarks_m / count);
  for (const FixAttempt& fix : result.fixes) ++(fix.accepted ? errors.fixes : errors.refused);
  return errors;
}

TEST(LevelledFixes, P31_FixesTellHowTheMapIsTurnedLong) {
  for (const std::uint64_t seed : {3U, 4U}) {
    const Errors without = two_dives(seed, false);
    const Errors with = two_dives(seed, true);
    for (const Errors& errors : {without, with}) {
      std::printf("seed %d, %d fixes used, %d refused: way %.2f m, landmarks %.2f m, inside three sigma %.1f %%\n", static_cast<int>(seed),
                  errors.fixes, errors.refused, errors.rmse_m, errors.landmarks_m, 100.0 * errors.inside);
      EXPECT_GT(errors.inside, 0.97);
    }
    EXPECT_GT(with.fixes, 20);
    EXPECT_LT(with.rmse_m, 1.0);
    EXPECT_LT(with.landmarks_m, without.landmarks_m);
  }
}

}  // namespace
}  // namespace ssjs
