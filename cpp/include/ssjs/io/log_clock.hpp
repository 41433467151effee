/// Times of a log: calendar fields to UTC seconds, and a running millisecond counter tied to coarser time stamps.
#pragma once

#include <cstdint>
#include <optional>

namespace ssjs {

/// Seconds since 1970 of a moment of the proleptic Gregorian calendar. None for fields that are no date or time (a leap second, 60, is
/// one).
[[nodiscard]] std::optional<double> utc_seconds(int year, int month, int day, int hour, int minute, int second);

/// The moment of that time of day nearest to `near_s`: records give the day once and other times without it. None if it is no time of day.
[[nodiscard]] std::optional<double> time_of_day_near(double near_s, int hour, int minute, int second);

/// A counter of milliseconds, the zero of which the log does not tell, beside time stamps cut to `resolution_s`. Each pair confines the
/// zero to an interval of that length; the common part of all intervals so far shrinks to about a millisecond. A pair that fits
/// none of it (the counter restarted, or has nothing to do with the stamps) starts anew.
class MillisecondCounter {
 public:
  explicit MillisecondCounter(double resolution_s) : resolution_s_(resolution_s) {}

  /// The time of this pair, within [stamp_s, stamp_s + resolution_s] and as exact as the pairs so far allow.
  [[nodiscard]] double refine(double stamp_s, std::uint32_t counter_ms);
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }

 private:
  double resolution_s_;
  bool tied_ = false;
  double earliest_zero_s_ = 0.0;
  double latest_zero_s_ = 0.0;
  std::uint64_t restarts_ = 0;
};

}  // namespace ssjs
