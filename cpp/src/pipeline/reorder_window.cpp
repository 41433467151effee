#include "ssjs/pipeline/reorder_window.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

constexpr std::size_t kSightingsExpected = 4;  // of one time; more is a one-time growth

bool is_finite(const NavigationTick& tick) {
  const auto scalar = [](const std::optional<double>& value) { return !value || std::isfinite(*value); };
  const auto sighting = [](const SideScanSighting& s) {
    return s.vehicle_p_point.allFinite() && (!s.covariance || s.covariance->allFinite());
  };
  return std::isfinite(tick.time_s) && (!tick.gyro_rad_s || tick.gyro_rad_s->allFinite()) &&
         (!tick.roll_pitch_rad || tick.roll_pitch_rad->allFinite()) && scalar(tick.compass_rad) && scalar(tick.depth_m) &&
         scalar(tick.altitude_m) && (!tick.velocity || (tick.velocity->velocity_m_s.allFinite() && scalar(tick.velocity->sigma_m_s))) &&
         std::all_of(tick.sightings.begin(), tick.sightings.end(), sighting);
}

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

Arrival ReorderWindow::put(const NavigationTick& tick) {
  if (!is_finite(tick)) return Arrival::kNotFinite;
  if (is_jump(tick.time_s)) return Arrival::kClockJump;
  if (given_out_s_ && tick.time_s <= *given_out_s_) return Arrival::kLate;
  if (newest_s_ && tick.time_s < *newest_s_ - config_.window_s) return Arrival::kLate;
  const auto at = waiting_.find(tick.time_s);
  if (at != waiting_.end()) {
    if (share_a_sensor(at->second, tick)) return Arrival::kDuplicate;
    take_in(at->second, tick);
    return Arrival::kTaken;
  }
  if (waiting_.size() >= static_cast<std::size_t>(config_.capacity)) return Arrival::kFlood;
  if (spare_.empty()) {
    waiting_.emplace(tick.time_s, tick).first->second.sightings.reserve(kSightingsExpected);
  } else {
    Ticks::node_type node = std::move(spare_.back());
    spare_.pop_back();
    node.key() = tick.time_s;
    node.mapped() = tick;
    waiting_.insert(std::move(node));
  }
  newest_s_ = std::max(newest_s_.value_or(tick.time_s), tick.time_s);
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
  std::sort(tick.sightings.begin(), tick.sightings.end(), comes_before);
  return &tick;
}

}  // namespace ssjs
