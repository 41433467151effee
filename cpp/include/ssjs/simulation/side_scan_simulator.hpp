/// Pings of a side-scan sonar over a simulated seabed. docs/math/side_scan.md (SS-24) to (SS-31)
///
/// Each ping is a fan of rays per side and beam direction: the seabed's profile along the fan with the objects on it, its parts lit in
/// order (exact occlusion on that profile), Lambert's echo of every lit part into the samples its slant ranges cover, spreading,
/// absorption and gain, the vertical pattern, then speckle. The vehicle stands still from transmission to the last echo.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/sensors/side_scan_ping.hpp"
#include "ssjs/simulation/seabed.hpp"
#include "ssjs/simulation/survey_track.hpp"

namespace ssjs {

struct SideScanSimulationConfig {
  double range_m = 30.0;
  int samples = 500;
  double frequency_hz = 900e3;
  double sound_speed_m_s = 1500.0;
  double beam_width_rad = 0.007;
  int beam_rays = 3;
  double vertical_beam_rad = 1.0;
  double depression_rad = 0.45;
  double absorption_db_m = 0.3;
  double gain_db_m = 0.3;
  double noise_db = -35.0;
  double transmit_m = 0.3;
  int looks = 1;
  double texture_shape = 0.0;
  double echo_level = 4000.0;
  int steps_per_sample = 2;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("range_m", range_m, Rule::positive(), "slant range of each side");
    v.field("samples", samples, Rule::at_least(16), "of each side, evenly from the transducer to the range");
    v.field("frequency_hz", frequency_hz, Rule::positive(), "written into the pings");
    v.field("sound_speed_m_s", sound_speed_m_s, Rule::positive(), "of the water and in the pings");
    v.field("beam_width_rad", beam_width_rad, Rule{0, 0.2, false, false}, "along track, two-way, at half power");
    v.field("beam_rays", beam_rays, Rule::closed(1, 3), "directions inside the beam: 1, 2 or 3");
    v.field("vertical_beam_rad", vertical_beam_rad, Rule{0, 3, true, false}, "across track, two-way, at half power");
    v.field("depression_rad", depression_rad, Rule::closed(0, 1.5), "of its axis below the horizon when the roll is 0");
    v.field("absorption_db_m", absorption_db_m, Rule::not_negative(), "of the water, one way");
    v.field("gain_db_m", gain_db_m, Rule::not_negative(), "by which the time-varying gain makes up for it");
    v.field("noise_db", noise_db, Rule::any(), "power at the transducer, amplified as the last sample, over that of sediment seen upright");
    v.field("transmit_m", transmit_m, Rule::not_negative(), "range in which the transmitted pulse is heard");
    v.field("looks", looks, Rule::at_least(1), "of the speckle; 1: Rayleigh amplitudes");
    v.field("texture_shape", texture_shape, Rule::not_negative(), "shape of the gamma texture that makes K-distributed speckle; 0: none");
    v.field("echo_level", echo_level, Rule::positive(), "amplitude of mean sediment seen upright on the axis of the beam");
    v.field("steps_per_sample", steps_per_sample, Rule::closed(1, 16), "points of the seabed's profile for the length of a sample");
  }
};

/// An object as it came abeam: the truth that detections are judged by.
struct ObjectSighting {
  std::int64_t object = 0;
  std::uint32_t ping = 0;
  SonarSide side = SonarSide::kStarboard;
  double slant_range_m = 0.0;                               ///< of the middle of its top
  double sample = 0.0;                                      ///< of that range
  Eigen::Vector3d body_p_object = Eigen::Vector3d::Zero();  ///< of the middle of its foot: x forward, y starboard, z down
};

class SideScanSimulator {
 public:
  /// Stream "speckle" of the seed.
  SideScanSimulator(Seabed seabed, const SideScanSimulationConfig& config, std::uint64_t seed);

  /// The next ping, with the true navigation, port before starboard. Numbers count from 0.
  [[nodiscard]] SideScanPing ping(const SonarPose& pose);

  /// The sonar is switched off until the next ping: what passes meanwhile is not seen.
  void pause() { last_pose_.reset(); }

  /// Objects that came abeam within range between the last two pings, in the order of the seabed's. Assigned to the nearer of the two.
  [[nodiscard]] const std::vector<ObjectSighting>& sightings() const { return sightings_; }

  [[nodiscard]] const Seabed& seabed() const { return seabed_; }
  [[nodiscard]] double sample_spacing_m() const { return spacing_m_; }
  /// Mean power of the samples of one side without speckle and noise: what the speckle multiplies.
  [[nodiscard]] std::vector<double> mean_power(const SonarPose& pose, SonarSide side);

 private:
  struct Fan;  ///< where a fan of rays meets the ground
  [[nodiscard]] Fan fan_of(const SonarPose& pose, SonarSide side, double beam_rad) const;
  void add_fan(const SonarPose& pose, SonarSide side, double beam_rad, double weight);
  void add_objects(const Fan& fan, int count);
  void add_echo(double near_m, double far_m, double power);
  void find_sightings(const SonarPose& pose, std::uint32_t number);
  [[nodiscard]] double pattern(double cosine) const;

  Seabed seabed_;
  SideScanSimulationConfig config_;
  double spacing_m_;
  Rng speckle_;
  std::uint32_t next_number_ = 0;
  std::vector<double> gain_;   ///< of the echo, by sample
  std::vector<double> noise_;  ///< power, by sample
  std::vector<double> pattern_;
  // Work of one fan, kept between pings.
  SeabedProfile profile_;
  std::vector<std::uint8_t> on_object_;
  std::vector<double> power_;
  // Objects ahead of (positive) or behind the fan at the last ping, m.
  std::vector<double> ahead_m_;
  std::optional<SonarPose> last_pose_;
  std::vector<ObjectSighting> sightings_;
};

}  // namespace ssjs
