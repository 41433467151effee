#include "ssjs/pipeline/reorder_window.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/measurement_noise.hpp"

namespace ssjs {
namespace {

bool is_usable(const PositionFix& fix) { return fix.world_p_vehicle.allFinite() && is_measurement_noise(fix.covariance); }

bool is_usable(const SideScanSighting& sighting) {
  return sighting.vehicle_p_point.allFinite() && (!sighting.covariance || is_measurement_noise(*sighting.covariance));
}

constexpr std::size_t kSightingsExpected = 4;  // of one time; more is a one-time growth

bool is_usable(const NavigationTick& tick) {
  const auto scalar = [](const std::optional<double>& value) { return !value || std::isfinite(*value); };
  return std::isfinite(tick.time_s) && (!tick.gyro_rad_s || tick.gyro_rad_s->allFinite()) &&
         (!tick.roll_pitch_rad || tick.roll_pitch_rad->allFinite()) && scalar(tick.compass_rad) && scalar(tick.depth_m) &&
         scalar(tick.altitude_m) && (!tick.velocity || (tick.velocity->velocity_m_s.allFinite() && scalar(tick.velocity->sigma_m_s))) &&
         (!tick.fix || is_usable(*tick.fix)) &&
         std::all_of(tick.sightings.begin(), tick.sightings.end(), [](const SideScanSighting& sighting) { return is_usable(sighting); });
}

/// A bit for each navigation sensor that speaks; sightings and fixes come from slower machines and say nothing of the clock.
unsigned kinds_of(const NavigationTick& tick) {
  return (tick.gyro_rad_s ? 1U : 0U) | (tick.roll_pitch_rad ? 2U : 0U) | (tick.compass_rad ? 4U : 0U) | (tick.depth_m ? 8U : 0U) |
         (tick.altitude_m ? 16U : 0U) | (tick.velocity ? 32U : 0U);
}
bool is_several(unsigned kinds) { return (kinds & (kinds - 1U)) != 0U; }

/// Any order will do that does not depend on which sighting arrived first.
bool comes_before(const SideScanSighting& a, const SideScanSighting& b) {
  const auto key = [](const SideScanSighting& s) {
    return std::make_tuple(s.vehicle_p_point.x(), s.vehicle_p_point.y(), s.vehicle_p_point.z(), s.landmark_id.value_or(-1));
  };
  return key(a) < key(b);
}

}  // namespace

ReorderWindow::ReorderWindow(const ReorderConfig& config) : config_(config) { throw_if_any(violations(config)); }

/// One mad stamp must not make everything after it late; a vehicle that was switched off for an hour must go on.
bool ReorderWindow::is_jump(double time_s) {
  if (!newest_s_ || time_s <= *newest_s_ + config_.max_gap_s) {
    if (newest_s_ && time_s > *newest_s_ - config_.max_gap_s) suspects_ = 0;
    return false;
  }
  const bool follows = suspect_s_ && std::abs(time_s - *suspect_s_) <= config_.max_gap_s;
  suspects_ = follows ? suspects_ + 1 : 1;
  suspect_s_ = time_s;
  if (suspects_ < config_.jump_samples) return true;
  suspects_ = 0;
  return false;
}

/// One sensor may lag. When all that arrives is late, from several sensors and on a clock that runs, the clock itself was set back.
bool ReorderWindow::was_set_back(double time_s, unsigned kinds) {
  if (kinds == 0) return false;
  const bool runs_on = late_in_a_row_ > 0 && time_s >= last_late_s_ - config_.window_s && time_s <= last_late_s_ + config_.max_gap_s;
  if (!runs_on) {
    late_in_a_row_ = 0;
    late_kinds_ = 0;
    first_late_s_ = time_s;
  }
  ++late_in_a_row_;
  late_kinds_ |= kinds;
  last_late_s_ = time_s;
  const bool several = is_several(late_kinds_) || !is_several(heard_kinds_);
  return several && late_in_a_row_ >= 2 * config_.jump_samples;
}

void ReorderWindow::set_clock(double by_s) {
  offset_s_ += by_s;
  ++clock_changes_;
}

Arrival ReorderWindow::put(const NavigationTick& tick) {
  if (!is_usable(tick)) return Arrival::kNotFinite;
  double time_s = tick.time_s + offset_s_;
  const std::optional<double> newest_before = newest_s_;
  if (is_jump(time_s)) return Arrival::kClockJump;
  if (!config_.gaps_are_silence && newest_before && time_s > *newest_before + config_.max_gap_s) {
    set_clock(*newest_before - time_s);
    time_s = *newest_before;
  }
  const bool is_late = (given_out_s_ && time_s <= *given_out_s_) || (newest_s_ && time_s < *newest_s_ - config_.window_s);
  if (is_late) {
    if (!was_set_back(time_s, kinds_of(tick))) return Arrival::kLate;
    const double by_s = *newest_s_ - first_late_s_;
    set_clock(by_s);
    time_s = std::max(time_s + by_s, *newest_s_);
  }
  late_in_a_row_ = 0;
  heard_kinds_ |= kinds_of(tick);
  const auto capacity = static_cast<std::size_t>(config_.capacity);
  if (sightings_ + tick.sightings.size() > capacity) return Arrival::kFlood;
  const auto at = waiting_.find(time_s);
  if (at != waiting_.end()) {
    if (share_a_sensor(at->second, tick)) return Arrival::kDuplicate;
    take_in(at->second, tick);
    sightings_ += tick.sightings.size();
    return Arrival::kTaken;
  }
  if (waiting_.size() >= capacity) return Arrival::kFlood;
  if (spare_.empty()) {
    NavigationTick& added = waiting_.emplace(time_s, tick).first->second;
    added.time_s = time_s;
    added.sightings.reserve(kSightingsExpected);
  } else {
    Ticks::node_type node = std::move(spare_.back());
    spare_.pop_back();
    node.key() = time_s;
    node.mapped() = tick;
    node.mapped().time_s = time_s;
    waiting_.insert(std::move(node));
  }
  sightings_ += tick.sightings.size();
  newest_s_ = std::max(newest_s_.value_or(time_s), time_s);
  return Arrival::kTaken;
}

const NavigationTick* ReorderWindow::take(bool all) {
  if (waiting_.empty()) return nullptr;
  const auto oldest = waiting_.begin();
  if (!all && !(*newest_s_ - oldest->first > config_.window_s)) return nullptr;
  given_out_s_ = oldest->first;
  if (taken_) spare_.push_back(std::move(taken_));
  taken_ = waiting_.extract(oldest);
  NavigationTick& tick = taken_.mapped();
  sightings_ -= tick.sightings.size();
  std::sort(tick.sightings.begin(), tick.sightings.end(), comes_before);
  return &tick;
}

}  // namespace ssjs
