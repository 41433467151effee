/// What goes wrong between the sensors of an underwater vehicle and its estimator, done to a recorded or simulated log. docs/faults.md
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "ssjs/base/random.hpp"
#include "ssjs/features/navigation_tick.hpp"

namespace ssjs {

/// Samples of single sensors in the order in which they reach the estimator. `taken_s` is when each was truly taken; tick.time_s is what
/// its stamp says.
struct ArrivingSample {
  double taken_s = 0.0;
  NavigationTick tick;
};
using ArrivingSamples = std::vector<ArrivingSample>;

/// Every sample by itself, in the order of the ticks.
[[nodiscard]] ArrivingSamples arriving(const std::vector<NavigationTick>& ticks);

/// From `begin_s` to before `end_s`, by when the samples were taken.
struct FaultTime {
  double begin_s = 0.0;
  double end_s = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool holds(double time_s) const { return time_s >= begin_s && time_s < end_s; }
};

/// Which of the sensors a fault is about: those that speak in this tick, whatever it says.
[[nodiscard]] NavigationTick all_sensors();

/// Each sample arrives up to `most_s` late, one by one; stamps are right.
void delay(ArrivingSamples& samples, const FaultTime& when, double most_s, Rng rng);
/// Stamps are wrong by so much.
void shift_clock(ArrivingSamples& samples, const FaultTime& when, double shift_s);
/// Each sample arrives `times` times, a little different but for the first.
void repeat(ArrivingSamples& samples, const FaultTime& when, int times);
/// Every `every`th sample of these sensors is not a number, or infinite.
void spoil(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, int every);
void silence(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors);
/// The first sample of the time is said again and again.
void hang(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors);
/// A fraction of the samples is off by up to `most`, each value by itself.
void add_outliers(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, double fraction, double most, Rng rng);
/// Values times this: other units.
void scale(ArrivingSamples& samples, const FaultTime& when, const NavigationTick& sensors, double factor);
/// So many sightings of nothing, evenly over the time and a swath of 30 m to both sides, 4 m below the vehicle.
void flood(ArrivingSamples& samples, const FaultTime& when, int sightings, Rng rng);
/// Positions off by this.
void displace_fixes(ArrivingSamples& samples, const FaultTime& when, const Eigen::Vector2d& by);

}  // namespace ssjs
