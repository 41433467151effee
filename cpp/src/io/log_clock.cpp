#include "ssjs/io/log_clock.hpp"

#include <algorithm>
#include <cmath>

namespace ssjs {
namespace {

constexpr double kSecondsPerDay = 86400.0;

/// Days since 1970-01-01; the year starts in March, so that the leap day is its last.
std::int64_t days_since_1970(int year, int month, int day) {
  const std::int64_t y = month <= 2 ? year - 1 : year;
  const std::int64_t era = (y >= 0 ? y : y - 399) / 400;
  const std::int64_t year_of_era = y - era * 400;
  const std::int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  const std::int64_t day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
  return era * 146097 + day_of_era - 719468;
}

bool is_time_of_day(int hour, int minute, int second) {
  return hour >= 0 && hour < 24 && minute >= 0 && minute < 60 && second >= 0 && second <= 60;
}

}  // namespace

std::optional<double> utc_seconds(int year, int month, int day, int hour, int minute, int second) {
  if (year < 1970 || year > 9999 || month < 1 || month > 12 || day < 1 || !is_time_of_day(hour, minute, second)) return std::nullopt;
  const std::int64_t days = days_since_1970(year, month, day);
  const std::int64_t next_month = month == 12 ? days_since_1970(year + 1, 1, 1) : days_since_1970(year, month + 1, 1);
  if (days >= next_month) return std::nullopt;  // the 30th of February
  return static_cast<double>(days) * kSecondsPerDay + hour * 3600.0 + minute * 60.0 + second;
}

std::optional<double> time_of_day_near(double near_s, int hour, int minute, int second) {
  if (!std::isfinite(near_s) || !is_time_of_day(hour, minute, second)) return std::nullopt;
  const double in_day_s = hour * 3600.0 + minute * 60.0 + second;
  return in_day_s + kSecondsPerDay * std::round((near_s - in_day_s) / kSecondsPerDay);
}

double MillisecondCounter::refine(double stamp_s, std::uint32_t counter_ms) {
  const double earliest = stamp_s - counter_ms * 1e-3;
  const double latest = earliest + resolution_s_;
  if (tied_ && std::max(earliest, earliest_zero_s_) <= std::min(latest, latest_zero_s_)) {
    earliest_zero_s_ = std::max(earliest, earliest_zero_s_);
    latest_zero_s_ = std::min(latest, latest_zero_s_);
  } else {
    if (tied_) ++restarts_;
    tied_ = true;
    earliest_zero_s_ = earliest;
    latest_zero_s_ = latest;
  }
  const double time_s = 0.5 * (earliest_zero_s_ + latest_zero_s_) + counter_ms * 1e-3;
  return std::min(std::max(time_s, stamp_s), stamp_s + resolution_s_);
}

}  // namespace ssjs
