#include <stdexcept>

#include "ssjs/simulation/survey_track.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

void add_contacts(SurveyRun& run, std::vector<SideScanContact> contacts) {
  for (SideScanContact& contact : contacts) run.contacts.push_back(std::move(contact));
}

void note_objects(SurveyRun& run, const Seabed& seabed) {
  run.objects = seabed.objects();
  for (std::size_t i = 0; i < run.objects.size(); ++i)
    run.feet_m.emplace_back(run.objects[i].position_m.x(), run.objects[i].position_m.y(), seabed.foot_depth_m(i));
}

SurveyRun over_lines(const SideScanSurveyConfig& config, std::uint64_t seed) {
  SurveyTrackConfig track;
  track.line_length_m = 150;
  SideScanSimulationConfig sonar;
  const double swath_m = 0.85 * sonar.range_m;
  const Eigen::Vector2d far_corner(track.line_length_m, (track.lines - 1) * track.line_spacing_m + swath_m);
  SideScanSimulator simulator(Seabed({}, scatter_objects(60, {0.0, -swath_m}, far_corner, 6.0, seed), seed), sonar, seed);
  SurveyRun run;
  note_objects(run, simulator.seabed());
  run.poses = survey_track(track, simulator.seabed(), {0, 0}, seed);
  SideScanSurvey survey(config);
  for (const SonarPose& pose : run.poses) {
    add_contacts(run, survey.feed(simulator.ping(pose)));
    run.sightings.insert(run.sightings.end(), simulator.sightings().begin(), simulator.sightings().end());
  }
  add_contacts(run, survey.finish());
  return run;
}

SurveyRun over_mission(const SideScanMissionConfig& world, const SideScanSurveyConfig& config, std::uint64_t seed) {
  SideScanMission mission(world, seed);
  SurveyRun run;
  run.objects = mission.objects();
  for (Eigen::Index i = 0; i < mission.survey().world.landmarks_m.cols(); ++i)
    run.feet_m.emplace_back(mission.survey().world.landmarks_m.col(i));
  SideScanSurvey survey(config);
  while (std::optional<SideScanPing> ping = mission.next_ping()) {
    run.poses.push_back(mission.pose_at(ping->time_s));
    run.sightings.insert(run.sightings.end(), mission.sightings().begin(), mission.sightings().end());
    add_contacts(run, survey.feed(std::move(*ping)));
  }
  add_contacts(run, survey.finish());
  return run;
}

}  // namespace

SurveyRun run_scenario(const std::string& scenario, const SideScanSurveyConfig& config, std::uint64_t seed) {
  if (scenario == "lines") return over_lines(config, seed);
  SideScanMissionConfig world;
  if (scenario == "large") {
    world.lines.lines = 11;
    world.lines.line_length_m = 400;
    world.lines.line_spacing_m = 30;
    world.lines.cross_lines = 5;
    world.objects = 300;
  } else if (scenario != "survey") {
    throw std::invalid_argument(scenario + ": must be lines, survey or large");
  }
  return over_mission(world, config, seed);
}

}  // namespace ssjs::benchmarks
