/// What a pilot or a supervisor acts on: how each sensor does, how well the position is known, and what to do about it. docs/embedding.md
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/pipeline/sensor_guard.hpp"

namespace ssjs {

enum class SurveyHealth {
  kWaiting,  ///< nothing heard yet
  kGood,
  kDegraded,  ///< a sensor is not good, or a fix contradicts the estimate: it is honest but worse than usual
  kLost,      ///< the position is known no better than lost_sigma_m
};

enum class SensorState {
  kUnheard,  ///< never spoke
  kGood,
  kSilent,     ///< spoke once; a velocity log without the bottom is silent
  kRefused,    ///< speaks, and the filter does not believe it
  kStuck,      ///< says the very same again and again
  kWrongUnit,  ///< would be right in another unit
};

/// How the samples of each sensor fared of late.
class SensorWatch {
 public:
  /// `arrived` as it came, `passed` what the guard left of it; before the filter sees it.
  void see(const NavigationTick& arrived);
  /// After the filter has seen it.
  void see(NavigationSensor sensor, double time_s, int used, int refused);

  [[nodiscard]] SensorState state(NavigationSensor sensor, double time_s, double silence_s, const SensorGuard& guard) const;
  /// Since it was last used; negative: never.
  [[nodiscard]] double unused_s(NavigationSensor sensor, double time_s) const;

 private:
  struct Sensor {
    bool spoke = false, was_used = false;
    double spoke_s = 0.0, used_s = 0.0;
    int refused_in_a_row = 0;

    void archive(Archive& a) {
      a("spoke", spoke);
      a("was_used", was_used);
      a("spoke_s", spoke_s);
      a("used_s", used_s);
      a("refused_in_a_row", refused_in_a_row);
    }
  };
  std::array<Sensor, kNavigationSensors> sensors_{};

 public:
  void archive(Archive& a) { a("sensors", sensors_); }
};

/// Something an operator wants to know.
enum class NoteKind { kSensor, kClock, kArrival, kFix, kRelocation, kClosure, kFailure };
struct SurveyNote {
  NoteKind kind;
  double time_s;
  std::string text;
};
using SurveyLog = std::function<void(const SurveyNote&)>;

[[nodiscard]] const char* name_of(NavigationSensor sensor);
[[nodiscard]] const char* name_of(SensorState state);
/// What to do about a sensor in this state; empty where it is good.
[[nodiscard]] std::string advice_for(NavigationSensor sensor, SensorState state);

/// Sensors that speak all the time: not sightings and fixes, which come when there is something to see.
[[nodiscard]] constexpr bool speaks_always(NavigationSensor sensor) {
  return sensor != NavigationSensor::kSideScan && sensor != NavigationSensor::kFix;
}

}  // namespace ssjs
