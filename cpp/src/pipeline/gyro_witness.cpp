#include "ssjs/pipeline/gyro_witness.hpp"

#include <algorithm>
#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/geometry/se3.hpp"

namespace ssjs {
namespace {

constexpr double kRatesHold_s = 1.0;       // a gyro that was silent for longer: nobody knows how it turned
constexpr double kLongestBlocks_s = 60.0;  // what took longer says more of the gyro's bias than of a fault
constexpr double kSteepest_rad = 1.2;
constexpr double kUnseen = 2.0;         // what medians show, half a block late, times this is what the filter may be wrong by
constexpr double kCompassFactor = 3.0;  // iron nearby turns a compass, too
constexpr int kMostNeeded = 1000;

}  // namespace

GyroWitness::GyroWitness(std::optional<double> disagreement_rad, int recover_blocks)
    : disagreement_rad_(disagreement_rad), recover_blocks_(recover_blocks) {}

void GyroWitness::forget() {
  angles_ = {};
  turned_rad_.setZero();
}

void GyroWitness::integrate_to(double time_s) {
  if (!rates_s_) return;
  if (time_s - *rates_s_ > kRatesHold_s || std::abs(roll_pitch_rad_.y()) > kSteepest_rad) {
    forget();
  } else {
    const Eigen::Vector3d rpy(roll_pitch_rad_.x(), roll_pitch_rad_.y(), 0.0);
    turned_rad_ += (time_s - turned_s_) * (inverse_euler_rate_matrix(rpy) * rates_rad_s_);
  }
  turned_s_ = time_s;
}

std::optional<double> GyroWitness::moved(Angle& angle, double time_s, double difference_rad) {
  if (angle.count == 0) angle.begin_s = time_s;
  if (angle.count == 0 && angle.blocks == 0) angle.reference_rad = difference_rad;
  angle.block[angle.count++] = angle_difference(difference_rad, angle.reference_rad);
  if (angle.count < kBlock) return std::nullopt;
  std::nth_element(angle.block.begin(), angle.block.begin() + kBlock / 2, angle.block.end());
  const double median = wrap_angle(angle.block[kBlock / 2] + angle.reference_rad);
  std::optional<double> moved;
  for (std::size_t i = 0; i < std::min(kMedians, static_cast<std::size_t>(angle.blocks)); ++i) {
    const Angle::Median& before = angle.medians[i];
    if (time_s - before.begin_s > kLongestBlocks_s) continue;
    moved = std::max(moved.value_or(0.0), std::abs(angle_difference(median, before.angle_rad)));
  }
  angle.medians[static_cast<std::size_t>(angle.blocks++) % kMedians] = {median, angle.begin_s};
  angle.reference_rad = median;
  angle.count = 0;
  return moved;
}

void GyroWitness::see(const NavigationTick& tick) {
  astray_rad_.reset();
  if (!disagreement_rad_) return;
  integrate_to(tick.time_s);
  if (tick.gyro_rad_s) {
    if (!rates_s_) turned_s_ = tick.time_s;
    rates_rad_s_ = *tick.gyro_rad_s;
    rates_s_ = tick.time_s;
  }
  if (!rates_s_) return;

  Eigen::Vector3d moved_rad = Eigen::Vector3d::Zero();
  bool is_judged = false;
  const auto offer = [&](Eigen::Index axis, double measured_rad) {
    const std::optional<double> by = moved(angles_[static_cast<std::size_t>(axis)], tick.time_s, measured_rad - turned_rad_(axis));
    if (!by) return;
    is_judged = true;
    moved_rad(axis) = *by;
  };
  if (tick.roll_pitch_rad && *tick.roll_pitch_rad != roll_pitch_rad_) {  // what hangs is no witness
    offer(0, tick.roll_pitch_rad->x());
    offer(1, tick.roll_pitch_rad->y());
    roll_pitch_rad_ = *tick.roll_pitch_rad;
  }
  if (tick.compass_rad && *tick.compass_rad != compass_rad_) {
    offer(2, *tick.compass_rad);
    compass_rad_ = *tick.compass_rad;
  }
  if (!is_judged) return;

  const double most = std::max({moved_rad(0), moved_rad(1), moved_rad(2) / kCompassFactor});
  if (!is_doubted_ && most > *disagreement_rad_) {
    is_doubted_ = true;
    needed_ = std::min(kMostNeeded, std::max(recover_blocks_, 2 * needed_));
    agreed_ = 0;
    astray_rad_ = Eigen::Vector3d::Constant(kUnseen * moved_rad.maxCoeff());
  } else if (is_doubted_) {
    agreed_ = most < 0.5 * *disagreement_rad_ ? agreed_ + 1 : 0;
    is_doubted_ = agreed_ < needed_;
  }
}

}  // namespace ssjs
