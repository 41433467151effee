/// A whole survey: the vehicle's navigation as it was measured, and the pings of the side-scan sonar along its true track.
/// docs/math/auv.md to, docs/math/side_scan.md (SS-20) to (SS-31)
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"
#include "ssjs/simulation/auv_survey.hpp"
#include "ssjs/simulation/seabed.hpp"
#include "ssjs/simulation/side_scan_simulator.hpp"

namespace ssjs {

struct SideScanMissionConfig {
  SurveyWorldConfig lines;  ///< its landmarks are not used: objects are
  AuvSimulationConfig vehicle;
  SeabedConfig seabed = default_seabed();
  SideScanSimulationConfig sonar = default_sonar();
  int objects = 60;
  double clearance_m = 6.0;
  double ping_interval_s = 0.143;
  std::optional<double> max_altitude_m;  ///< the sonar is off while the vehicle measures more, such as at the surface
  template <class Visitor>
  void visit(Visitor& v) {
    v.section("lines", lines, "the lines; objects lie where its landmarks would");
    v.section("vehicle", vehicle, "motion and navigation sensors");
    v.section("seabed", seabed, "relief and sediment");
    v.section("sonar", sonar, "the side-scan sonar, at the vehicle's reference point");
    v.field("objects", objects, Rule::not_negative(), "objects on the seabed");
    v.field("clearance_m", clearance_m, Rule::not_negative(), "least distance between two of them");
    v.field("ping_interval_s", ping_interval_s, Rule::positive(), "between two pings");
    v.field("max_altitude_m", max_altitude_m, Rule::positive(), "the sonar is off while the vehicle is higher above the seabed");
  }

  /// As deep as the landmarks of `SurveyWorldConfig`.
  [[nodiscard]] static SeabedConfig default_seabed();
  [[nodiscard]] static SideScanSimulationConfig default_sonar();
};

/// Pings come one by one, so that their number does not count.
class SideScanMission {
 public:
  /// Streams of the seed: those of simulate_survey(), scatter_objects(), Seabed and SideScanSimulator.
  /// Throws InvalidArgument for a configuration out of its rules, a path that cannot be driven, or no room for the objects.
  SideScanMission(const SideScanMissionConfig& config, std::uint64_t seed);

  /// Without sightings: those are in the pings. The world's landmarks are the feet of the objects.
  [[nodiscard]] const SimulatedSurvey& survey() const { return survey_; }
  [[nodiscard]] const std::vector<SeabedObject>& objects() const { return simulator_.seabed().objects(); }

  /// Echoes from where the vehicle truly is; the navigation beside them is what its sensors said last. None at the end of the mission.
  [[nodiscard]] std::optional<SideScanPing> next_ping();
  /// Objects that came abeam of the last ping.
  [[nodiscard]] const std::vector<ObjectSighting>& sightings() const { return simulator_.sightings(); }
  /// Where the sonar truly is at that time, which must not lie after the mission's end.
  [[nodiscard]] SonarPose pose_at(double time_s) const;

 private:
  void update_navigation(double time_s);
  [[nodiscard]] bool sonar_is_off() const;

  SideScanSimulator simulator_;
  SimulatedSurvey survey_;
  double ping_interval_s_;
  std::optional<double> max_altitude_m_;
  std::size_t triggers_ = 0;   ///< times at which a ping was due
  std::size_t next_tick_ = 0;  ///< the first that is not yet in `measured_`
  SideScanPing measured_;      ///< the navigation alone
};

}  // namespace ssjs
