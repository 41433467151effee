/// Contacts of simulated surveys against the objects that lie there. See ../README.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ssjs/simulation/side_scan_mission.hpp"
#include "ssjs/survey/side_scan_survey.hpp"

namespace ssjs::benchmarks {

/// One survey: what came abeam of the sonar, the sonar's true poses, and the contacts found in its pings.
struct SurveyRun {
  std::vector<SeabedObject> objects;
  std::vector<Eigen::Vector3d> feet_m;  ///< of the objects, world frame
  std::vector<SonarPose> poses;         ///< by ping
  std::vector<ObjectSighting> sightings;
  std::vector<SideScanContact> contacts;
};

/// "lines": four lines of 150 m over 60 objects, true navigation in the pings. "survey" and "large": the missions that
/// `ssjs-cli simulate side-scan-survey` and `side-scan-survey-large` write. Throws std::invalid_argument on another name.
[[nodiscard]] SurveyRun run_scenario(const std::string& scenario, const SideScanSurveyConfig& config, std::uint64_t seed);

/// What one contact is: of which object, and how far from it in the body frame of its ping.
struct JudgedContact {
  const SideScanContact* contact = nullptr;
  const SeabedObject* object = nullptr;                  ///< the nearest one within kMatch_m; none: the contact is false
  Eigen::Vector2d error_m = Eigen::Vector2d::Zero();     ///< along track (forward) and across track (positive: too far from the sonar)
  double nis = 0;                                        ///< of both errors by the contact's own covariance
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();  ///< errors by their own standard deviations
  bool in_turn = false;
  bool is_second = false;  ///< another contact of that pass is nearer to the object
};

/// One pass of an object: it came abeam outside turns, in the swath.
struct JudgedPass {
  const SeabedObject* object = nullptr;
  double ground_range_m = 0;
  bool found = false;
};

struct Judgement {
  std::vector<JudgedContact> contacts;
  std::vector<JudgedPass> passes;
};

constexpr double kMatch_m = 2.0;
constexpr double kLeastGroundRange_m = 1.5;
constexpr double kMostGroundRange_m = 28.0;

[[nodiscard]] Judgement judge(const SurveyRun& run, const SideScanSurveyConfig& config);

}  // namespace ssjs::benchmarks
