/// Simulated pings for the tests of survey/.
#pragma once

#include <utility>
#include <vector>

#include "ssjs/simulation/side_scan_simulator.hpp"

namespace ssjs::testing {

struct SimulatedSurvey {
  Seabed seabed;
  std::vector<SideScanPing> pings;
  std::vector<ObjectSighting> sightings;
};

inline SimulatedSurvey simulated_survey(const SeabedConfig& bottom, std::vector<SeabedObject> objects, const SurveyTrackConfig& track,
                                        const SideScanSimulationConfig& sonar, std::uint64_t seed) {
  SimulatedSurvey survey{Seabed(bottom, std::move(objects), seed), {}, {}};
  SideScanSimulator simulator(survey.seabed, sonar, seed);
  for (const SonarPose& pose : survey_track(track, survey.seabed, {0, 0}, seed)) {
    survey.pings.push_back(simulator.ping(pose));
    survey.sightings.insert(survey.sightings.end(), simulator.sightings().begin(), simulator.sightings().end());
  }
  return survey;
}

inline SurveyTrackConfig one_line(double length_m) {
  SurveyTrackConfig track;
  track.lines = 1;
  track.line_length_m = length_m;
  return track;
}

}  // namespace ssjs::testing
