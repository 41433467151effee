/// Stands between what arrives and the filter: samples that no such vehicle can give, that hang, that come in other units or in a flood.
/// docs/faults.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/pipeline/gyro_witness.hpp"

namespace ssjs {

/// What is wrong with a sensor, by the samples of it that arrive.
enum class SampleFault {
  kNone,
  kRange,  ///< no such vehicle does that
  kUnit,   ///< out of range or a leap, and what it would be in another unit is where the last one was
  kStuck,  ///< the very same value again and again, while others move
  kFlood,  ///< more sightings than the vehicle can pass
  kAlone,  ///< what other sensors say of the same is otherwise
};

struct GuardConfig {
  double max_depth_m = 6500.0;
  double max_altitude_m = 1000.0;
  double max_speed_m_s = 20.0;
  double max_tilt_rad = 1.3;
  double max_turn_rate_rad_s = 2.0;
  std::optional<double> stuck_s = 10.0;
  int stuck_samples = 20;
  int recover_samples = 20;
  std::optional<int> max_sightings_per_min = 300;
  std::optional<double> gyro_disagreement_rad = 0.1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("max_depth_m", max_depth_m, Rule::positive(), "a deeper reading is not believed");
    v.field("max_altitude_m", max_altitude_m, Rule::positive(), "a higher reading is not believed");
    v.field("max_speed_m_s", max_speed_m_s, Rule::positive(), "a faster velocity is not believed");
    v.field("max_tilt_rad", max_tilt_rad, Rule::positive(), "more roll or pitch is not believed");
    v.field("max_turn_rate_rad_s", max_turn_rate_rad_s, Rule::positive(), "a faster turn is not believed");
    v.field("stuck_s", stuck_s, Rule::positive(),
            "a velocity, attitude or turn rate that does not change by a bit for so long is a sensor that hangs; a compass, depth or "
            "altitude, which may be rounded, after three times as long; without it nobody looks");
    v.field("stuck_samples", stuck_samples, Rule::at_least(3), "... and in so many samples");
    v.field(
        "recover_samples", recover_samples, Rule::at_least(1),
        "a sensor that was found out of range or in another unit is believed after so many good samples in a row, twice as many each time");
    v.field("max_sightings_per_min", max_sightings_per_min, Rule::at_least(1), "more sightings are a flood and are refused");
    v.field(
        "gyro_disagreement_rad", gyro_disagreement_rad, Rule::positive(),
        "a gyro that turned by so much otherwise than attitude and compass, by the medians of fifteen of their samples, is not believed; "
        "without it nobody looks");
  }
};

class SensorGuard {
 public:
  explicit SensorGuard(const GuardConfig& config);

  /// The tick less what is not believed, until the next call. Times must not decrease.
  [[nodiscard]] const NavigationTick& pass(const NavigationTick& arrived);

  [[nodiscard]] SampleFault fault(NavigationSensor sensor) const { return watched_[index(sensor)].fault; }
  [[nodiscard]] std::int64_t refused(NavigationSensor sensor) const { return watched_[index(sensor)].refused; }
  /// Standard deviations of roll, pitch and yaw (rad) by which the filter may have been turned by a gyro that pass() has just begun to
  /// doubt.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& astray_rad() const { return gyro_.astray_rad(); }
  [[nodiscard]] const GuardConfig& config() const { return config_; }

 private:
  static constexpr std::size_t kMostValues = 3;
  using Values = std::array<double, kMostValues>;  ///< unused ones are 0
  struct Watched {
    SampleFault fault = SampleFault::kNone;
    std::int64_t refused = 0;
    int good_in_a_row = 0;  ///< since the last bad one
    int needed = 0;         ///< of those, to be believed again
    bool is_doubted = false;
    std::optional<Values> last;  ///< that arrived
    double same_since_s = 0.0;
    int same = 0;                     ///< in a row, the first included
    std::int64_t changes_before = 0;  ///< of all sensors, when this value came first
    std::optional<Values> believed;   ///< the last one
    double believed_s = 0.0;

    void archive(Archive& a) {
      a.choice("fault", fault, SampleFault::kAlone);
      a("refused", refused);
      a("good_in_a_row", good_in_a_row);
      a("needed", needed);
      a("is_doubted", is_doubted);
      a("last", last);
      a("same_since_s", same_since_s);
      a("same", same);
      a("changes_before", changes_before);
      a("believed", believed);
      a("believed_s", believed_s);
    }
  };

  [[nodiscard]] static std::size_t index(NavigationSensor sensor) { return static_cast<std::size_t>(sensor); }
  [[nodiscard]] bool believe(NavigationSensor sensor, double time_s, const Values& values);
  [[nodiscard]] bool is_stuck(NavigationSensor sensor, double time_s, const Values& values);
  [[nodiscard]] SampleFault plausible(NavigationSensor sensor, double time_s, const Values& values) const;
  [[nodiscard]] bool in_range(NavigationSensor sensor, const Values& values) const;
  [[nodiscard]] bool is_other_unit(NavigationSensor sensor, double time_s, const Values& values) const;
  void limit_sightings(NavigationTick& tick);

  GuardConfig config_;
  std::array<Watched, kNavigationSensors> watched_{};
  std::int64_t changes_ = 0;              ///< of any sensor's value
  std::optional<double> sightings_left_;  ///< of the allowance that refills
  double refilled_s_ = 0.0;
  GyroWitness gyro_;
  NavigationTick passed_;  ///< of the tick at hand

 public:
  void archive(Archive& a) {
    a("watched", watched_);
    a("changes", changes_);
    a("sightings_left", sightings_left_);
    a("refilled_s", refilled_s_);
    a("gyro", gyro_);
  }
};

}  // namespace ssjs
