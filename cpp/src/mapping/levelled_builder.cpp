#include "ssjs/mapping/levelled_builder.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ssjs/base/chi_squared.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using Layout = VehicleLayout;

constexpr double kLeastVariance = 1e-12;      // of an exit: a vehicle that has not moved is where it was to a micrometre
constexpr double kLeastDriftVariance = 1e-9;  // rad^2, between the offsets at the borders of a map that took no time
constexpr double kUnknownOffsetRad = 10.0;    // sigma of an offset that no reading told
constexpr double kCompassHoldsS = 2.0;        // a compass that is silent for longer says nothing of the heading
constexpr double kAttitudeHoldsS = 2.0;       // the same of roll and pitch, without which no map is begun ...
constexpr double kAttitudeLostS = 1800.0;     // ... unless they never come back
constexpr double kUntoldTurn = 0.25;          // rad/sqrt(s): a survey's turns, where neither gyro nor compass tells of them
constexpr double kShortestFixedMapS = 5.0;    // a fix does not close a younger map
constexpr double kFixWaitsS = 2.0;            // ... and waits so long for a velocity that the next map begins with
constexpr double kSilenceS = 5.0;             // without any sample, and ten times as long as usual: the vehicle may have done anything ...
constexpr double kUnusual = 10.0;
constexpr double kDoubtedFor_s = 3.0;  // a gyro went astray before it showed
constexpr double kSteepest = 1.4;      // rad of pitch, beyond which attitude has no derivatives and no such vehicle goes
constexpr double kForgottenS = 900.0;  // ... and after this nothing of it is known
constexpr double kLongestS = 1e6;      // no vehicle is under way for longer; squares of more leave a covariance no digits
constexpr std::size_t kInitialSightings = 1024;
constexpr std::size_t kBlocksOfATick = 16;     // sensors and sightings; more is a one-time growth
constexpr Eigen::Index kInitialCapacity = 32;  // landmarks of a map without a limit; grows when a map does
constexpr Eigen::Index kBeyondTheLimit = 4;    // a map that is full is closed at a tick with a velocity
constexpr Eigen::Index kLargestReserved = 256;

double squared(double x) { return x * x; }
std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

LevelledBuilderConfig checked(LevelledBuilderConfig config) {
  throw_if_any(violations(config));
  if (config.compass_use == CompassUse::kFirstReading) config.motion.compass_walk_rad_sqrt_s = 0.0;  // an offset taken for exact
  return config;
}

/// The tick less what its gates refused: a new map does not begin with an outlier.
NavigationTick without(NavigationTick tick, const std::vector<NavigationSensor>& refused) {
  for (const NavigationSensor sensor : refused) {
    if (sensor == NavigationSensor::kAttitude) tick.roll_pitch_rad.reset();
    if (sensor == NavigationSensor::kCompass) tick.compass_rad.reset();
    if (sensor == NavigationSensor::kDepth) tick.depth_m.reset();
    if (sensor == NavigationSensor::kAltitude) tick.altitude_m.reset();
    if (sensor == NavigationSensor::kVelocityLog) tick.velocity.reset();
  }
  return tick;
}

/// RMS of 1 - cos(e), e ~ N(0, variance): what a heading error e takes off a way of 1 m, beyond the first order.
double shortening(double variance) {
  if (variance < 1e-3) return std::sqrt(0.75) * variance;
  return std::sqrt(1.5 - 2.0 * std::exp(-0.5 * variance) + 0.5 * std::exp(-2.0 * variance));
}

Eigen::Index landmark_capacity(const SplitPolicyConfig& policy) {
  if (!policy.max_landmarks) return kInitialCapacity;
  return std::min<Eigen::Index>(*policy.max_landmarks + kBeyondTheLimit, kLargestReserved);
}

bool corrects_heading(CompassUse use) { return use == CompassUse::kFilter || use == CompassUse::kFirstReading; }

}  // namespace

LevelledBuilder::LevelledBuilder(const LevelledBuilderConfig& config, StepSmoothing smoothing)
    : config_(checked(config)),
      filter_(landmark_capacity(config.split.policy)),
      journal_(config.condition_trajectory),
      fixes_(config.split.fix_interval_s),
      camera_(pinhole_camera(config.camera)),
      smoothing_(smoothing) {
  if (config.condition_trajectory) filter_.watch(&journal_);
  gated_.rows.reserve(kBlocksOfATick);
  gated_.sensors.reserve(kBlocksOfATick);
  gated_.distances.reserve(kBlocksOfATick);
  gated_.refused.reserve(kNavigationSensors);
  association_.pairs.reserve(kBlocksOfATick);
  association_.fresh.reserve(kBlocksOfATick);
  seen_.reserve(kInitialSightings);
}

TickResult LevelledBuilder::feed(const NavigationTick& tick) {
  if (!std::isfinite(tick.time_s) || (started_ && tick.time_s < time_s_)) {
    throw InvalidArgument("NavigationTick.time_s", tick.time_s, "must be finite and not before the tick before it");
  }
  if (tick.gyro_rad_s && !tick.gyro_rad_s->allFinite()) throw InvalidArgument("NavigationTick.gyro_rad_s", "not finite", "must be finite");
  TickResult result;
  if (!started_) {
    begin_map(tick, result);
    return result;
  }
  if (tick.time_s - time_s_ > kForgottenS) {
    forget_until(tick.time_s);
  } else {
    predict_to(tick.time_s);
  }
  gate_rows(tick, true);
  associate(tick);
  const double unlevelled_s = attitude_time_s_ ? time_s_ - *attitude_time_s_ : 0.0;
  const bool can_begin = unlevelled_s <= kAttitudeHoldsS || unlevelled_s > kAttitudeLostS;
  if (tick.fix) fixes_.keep(tick.time_s, *tick.fix, filter_.vehicle());
  if (can_begin) {
    const std::size_t fresh = association_.fresh.size() + (frame_ ? frame_->fresh.size() : 0);
    if (const auto reason = reason_to_close_map(static_cast<int>(fresh))) {  // its samples are the new map's alone
      result.closed = close(*reason, &result.steps);
      const std::vector<NavigationSensor> refused = gated_.refused;
      begin_map(without(tick, refused), result);
      count_refused(refused, result);
      return result;
    }
  }
  count_refused(gated_.refused, result);
  use(tick, result);
  return result;
}

void LevelledBuilder::count_refused(const std::vector<NavigationSensor>& refused, TickResult& result) {
  for (const NavigationSensor sensor : refused) ++statistics_[static_cast<std::size_t>(sensor)].refused;
  result.refused = static_cast<int>(refused.size());
}

void LevelledBuilder::begin_map(const NavigationTick& tick, TickResult& result) {
  const bool is_first = !started_;
  start(tick);
  if (is_first && tick.fix) {
    fixes_.keep(tick.time_s, *tick.fix, filter_.vehicle());
    start_fix_ = fixes_.take(tick.time_s, filter_.vehicle(), filter_.vehicle_covariance());
  }
  gate_rows(tick, false);
  associate(tick);
  use(tick, result);
}

void LevelledBuilder::associate(const NavigationTick& tick) {
  associate_sightings(tick.sightings, filter_, landmarks_, config_.side_scan, config_.association, association_);
  frame_.reset();
  if (!tick.frame) return;
  if (!camera_) throw InvalidArgument("camera.fx_px", "missing", "must be given for a log with frames, as the rest of the camera");
  for (const CameraSighting& sighting : tick.frame->sightings) {
    if (!sighting.pixel.allFinite() || !sighting.descriptor.allFinite())
      throw InvalidArgument("NavigationTick.frame", "not finite", "must have finite pixels and descriptors");
  }
  frame_ = associate_frame(*tick.frame, filter_, landmarks_, *camera_, config_.camera, config_.camera_association, config_.association);
}

void LevelledBuilder::start(const NavigationTick& tick) {
  const LevelledStartConfig& config = config_.start;
  // linearisation points of what this tick may not measure; wide, so that nothing of the map before is carried over
  const VehicleVector before = started_ ? filter_.vehicle() : VehicleVector(VehicleVector::Zero());
  VehicleVector x = VehicleVector::Zero();
  x(Layout::kPosition + 2) = before(Layout::kPosition + 2);
  x(Layout::kAttitude) = before(Layout::kAttitude);
  x(Layout::kAttitude + 1) = before(Layout::kAttitude + 1);
  x(Layout::kVelocity) = config.speed_m_s;
  x(Layout::kSeabed) = x(Layout::kPosition + 2) + config.altitude_m;
  VehicleMatrix P = VehicleMatrix::Zero();
  const double depth_variance = squared(config.depth_sigma_m);
  P(Layout::kPosition + 2, Layout::kPosition + 2) = depth_variance;
  P(Layout::kAttitude, Layout::kAttitude) = P(Layout::kAttitude + 1, Layout::kAttitude + 1) = squared(config.tilt_sigma_rad);
  P.block<3, 3>(Layout::kVelocity, Layout::kVelocity).diagonal().setConstant(squared(config.speed_sigma_m_s));
  P(Layout::kSeabed, Layout::kSeabed) = depth_variance + squared(config.altitude_sigma_m);
  P(Layout::kSeabed, Layout::kPosition + 2) = P(Layout::kPosition + 2, Layout::kSeabed) = depth_variance;
  if (config_.motion.drive == RotationDrive::kRates) {
    P.block<3, 3>(Layout::kRates, Layout::kRates).diagonal().setConstant(squared(config.rates_sigma_rad_s));
  }
  P.block<3, 3>(Layout::kGyroBias, Layout::kGyroBias).diagonal().setConstant(squared(config.gyro_bias_sigma_rad_s));
  P(Layout::kLogScale, Layout::kLogScale) = squared(config.log_scale_sigma);
  P(Layout::kLogYaw, Layout::kLogYaw) = squared(config.log_yaw_sigma_rad);
  filter_.reset(x, P);
  journal_.clear();
  landmarks_.clear();
  missed_.clear();
  seen_.clear();
  start_time_s_ = time_s_ = tick.time_s;
  last_step_s_ = tick.time_s - 2.0 * config_.trajectory_interval_s;
  distance_m_ = shortened_m_ = 0.0;
  offset_known_ = false;
  met_.fill(false);
  was_silent_ = false;
  mean_samples_ = 0;
  started_ = true;
}

void LevelledBuilder::predict_to(double time_s) {
  const double gap_s = time_s - time_s_;
  if (!(gap_s > 0.0)) return;
  const double steps = std::ceil(gap_s / config_.max_step_s * (1.0 - 1e-9));
  for (int i = 0; i < static_cast<int>(steps); ++i) {
    ConstantVelocityConfig motion_config = config_.motion;
    const bool gyro_speaks = gyro_rad_s_ && time_s_ + gap_s * (i + 1) / steps - gyro_time_s_ <= kGyroHolds * config_.motion.gyro_step_s;
    if (motion_config.drive == RotationDrive::kGyro && !gyro_speaks) motion_config.drive = RotationDrive::kConstantAttitude;
    VehiclePrediction motion =
        predict_constant_velocity(filter_.vehicle(), gyro_rad_s_.value_or(Eigen::Vector3d::Zero()), gap_s / steps, motion_config);
    const double way_m = (motion.state - filter_.vehicle()).segment<2>(Layout::kPosition).norm();
    distance_m_ += way_m;
    constexpr Eigen::Index kYaw = Layout::kAttitude + 2;
    if (config_.motion.drive == RotationDrive::kGyro && !gyro_speaks && !(time_s - compass_time_s_ <= kCompassHoldsS)) {
      motion.Q(kYaw, kYaw) += squared(kUntoldTurn) * gap_s / steps;
    }
    const double before_m = shortened_m_;  // the same heading error takes from every metre, so that the metres add up
    shortened_m_ += way_m * shortening(filter_.vehicle_covariance()(kYaw, kYaw));
    motion.Q.topLeftCorner<2, 2>().diagonal().array() += squared(shortened_m_) - squared(before_m);
    filter_.predict(motion);
    level_again();
  }
  if (gap_s > std::max(kSilenceS, kUnusual * usual_gap_s_)) add_doubt(gap_s);
  usual_gap_s_ += 0.01 * (gap_s - usual_gap_s_);
  time_s_ = time_s;
}

/// That the vehicle went on all the time without a word is a guess; it may as well have stood.
void LevelledBuilder::add_doubt(double gap_s) {
  VehiclePrediction doubt{filter_.vehicle(), VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  const double way_m = gap_s * filter_.vehicle().segment<2>(Layout::kVelocity).norm();
  doubt.Q.topLeftCorner<2, 2>().diagonal().setConstant(squared(0.5 * way_m));
  filter_.predict(doubt);
  was_silent_ = true;
}

void LevelledBuilder::doubt_attitude(const Eigen::Vector3d& sigma_rad) {
  if (!started_) return;
  VehiclePrediction doubt{filter_.vehicle(), VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  const double way_m = kDoubtedFor_s * filter_.vehicle().segment<2>(Layout::kVelocity).norm();
  doubt.Q.diagonal().segment<3>(Layout::kAttitude) = sigma_rad.array().square();
  doubt.Q.topLeftCorner<2, 2>().diagonal().setConstant(squared(way_m * sigma_rad.z()));
  filter_.predict(doubt);
  gyro_rad_s_.reset();  // its last sample does not hold
  met_[static_cast<std::size_t>(NavigationSensor::kAttitude)] = false;
  met_[static_cast<std::size_t>(NavigationSensor::kCompass)] = false;
}

/// A pitch that no such vehicle has comes of samples that were believed and wrong: tilt is met anew.
void LevelledBuilder::level_again() {
  if (std::abs(filter_.vehicle()(Layout::kAttitude + 1)) <= kSteepest) return;
  VehiclePrediction level{filter_.vehicle(), VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  level.F.middleRows<2>(Layout::kAttitude).setZero();
  level.state.segment<2>(Layout::kAttitude).setZero();
  level.Q.diagonal().segment<2>(Layout::kAttitude).setConstant(squared(config_.start.tilt_sigma_rad));
  filter_.predict(level);
  met_[static_cast<std::size_t>(NavigationSensor::kAttitude)] = false;
}

void LevelledBuilder::forget_until(double time_s) {
  const LevelledStartConfig& config = config_.start;
  const double gap_s = std::min(time_s - time_s_, kLongestS);
  VehiclePrediction lost{filter_.vehicle(), VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  const auto anew = [&](Eigen::Index first, Eigen::Index count, double value, double sigma) {
    lost.F.middleRows(first, count).setZero();
    lost.state.segment(first, count).setConstant(value);
    lost.Q.diagonal().segment(first, count).setConstant(squared(sigma));
  };
  constexpr Eigen::Index kDepth = Layout::kPosition + 2;
  constexpr Eigen::Index kYaw = Layout::kAttitude + 2;
  const double reach_m = gap_s * (std::abs(config.speed_m_s) + 2.0 * config.speed_sigma_m_s);
  lost.Q.topLeftCorner<2, 2>().diagonal().setConstant(squared(0.5 * reach_m));  // anywhere in a disc of this radius
  lost.Q(kDepth, kDepth) = squared(config.depth_sigma_m);
  anew(Layout::kAttitude, 2, 0.0, config.tilt_sigma_rad);
  lost.Q(kYaw, kYaw) = kPi * kPi / 3.0;  // any heading
  anew(Layout::kVelocity, 3, 0.0, std::hypot(config.speed_m_s, config.speed_sigma_m_s));
  anew(Layout::kSeabed, 1, lost.state(kDepth) + config.altitude_m, config.altitude_sigma_m);
  lost.F(Layout::kSeabed, kDepth) = 1.0;
  lost.Q(Layout::kSeabed, Layout::kSeabed) += squared(config.depth_sigma_m);
  lost.Q(Layout::kSeabed, kDepth) = lost.Q(kDepth, Layout::kSeabed) = squared(config.depth_sigma_m);
  lost.Q(Layout::kCompassOffset, Layout::kCompassOffset) = squared(config_.motion.compass_walk_rad_sqrt_s) * gap_s;
  if (config_.motion.drive == RotationDrive::kRates) anew(Layout::kRates, 3, 0.0, config.rates_sigma_rad_s);
  filter_.predict(lost);
  distance_m_ += reach_m;
  gyro_rad_s_.reset();
  met_.fill(false);  // what they say now decides
  was_silent_ = true;
  time_s_ = time_s;
}

void LevelledBuilder::gate_rows(const NavigationTick& tick, bool gates) {
  GatedRows& gated = gated_;
  gated.rows.clear();
  gated.sensors.clear();
  gated.distances.clear();
  gated.refused.clear();
  gated.velocity_valid = false;
  const VehicleVector x = filter_.vehicle();
  const auto offer = [&](NavigationSensor sensor, const VehicleRows& vehicle, double gate_probability) {
    StateRows rows{vehicle};
    const double distance = filter_.squared_distance(rows);
    const bool met = met_[static_cast<std::size_t>(sensor)];  // its first sample in a map decides, whatever was expected
    if (gates && met && !(distance <= chi_squared_quantile(gate_probability, static_cast<double>(rows.rows())))) {
      gated.refused.push_back(sensor);
      return false;
    }
    gated.rows.push_back(std::move(rows));
    gated.sensors.push_back(sensor);
    gated.distances.push_back(distance);
    return true;
  };
  if (tick.roll_pitch_rad)
    offer(NavigationSensor::kAttitude, attitude_rows(x, *tick.roll_pitch_rad, config_.attitude), config_.attitude.gate_probability);
  if (tick.compass_rad && corrects_heading(config_.compass_use) && offset_known_) {
    offer(NavigationSensor::kCompass, compass_rows(x, *tick.compass_rad, config_.compass), config_.compass.gate_probability);
  }
  if (tick.depth_m) offer(NavigationSensor::kDepth, depth_rows(x, *tick.depth_m, config_.depth), config_.depth.gate_probability);
  if (tick.velocity && tick.velocity->bottom_lock) {
    const bool rates_are_states = config_.motion.drive == RotationDrive::kRates;
    std::optional<Eigen::Vector3d> rates;
    if (!rates_are_states) rates = tick.gyro_rad_s ? *tick.gyro_rad_s : gyro_rad_s_.value_or(Eigen::Vector3d::Zero());
    gated.velocity_valid = offer(NavigationSensor::kVelocityLog, velocity_log_rows(x, *tick.velocity, rates, config_.velocity_log),
                                 config_.velocity_log.gate_probability);
  }
  if (tick.altitude_m)
    offer(NavigationSensor::kAltitude, altitude_rows(x, *tick.altitude_m, config_.altitude), config_.altitude.gate_probability);
}

void LevelledBuilder::introduce_offset(double compass_rad, double sigma_rad) {
  const VehicleVector x = filter_.vehicle();
  // c = reading - yaw, whatever was there before; c_s = c less the drift since the map started
  VehiclePrediction now{x, VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  now.state(Layout::kCompassOffset) = wrap_angle(compass_rad - x(Layout::kAttitude + 2));
  now.F.row(Layout::kCompassOffset).setZero();
  if (config_.compass_use == CompassUse::kFilter) {
    now.F(Layout::kCompassOffset, Layout::kAttitude + 2) = -1.0;
    now.Q(Layout::kCompassOffset, Layout::kCompassOffset) = squared(sigma_rad);
  }
  filter_.predict(now);
  VehiclePrediction at_start{now.state, VehicleMatrix::Identity(), VehicleMatrix::Zero()};
  at_start.state(Layout::kStartOffset) = now.state(Layout::kCompassOffset);
  at_start.F.row(Layout::kStartOffset).setZero();
  at_start.F(Layout::kStartOffset, Layout::kCompassOffset) = 1.0;
  at_start.Q(Layout::kStartOffset, Layout::kStartOffset) = squared(config_.motion.compass_walk_rad_sqrt_s) * (time_s_ - start_time_s_);
  filter_.predict(at_start);
  offset_known_ = true;
}

void LevelledBuilder::add_to_mean(double time_s, double compass_rad) {
  const double offset = compass_rad - filter_.vehicle()(Layout::kAttitude + 2);
  if (mean_samples_ == 0) {
    mean_reference_rad_ = wrap_angle(offset);
    mean_sum_rad_ = 0.0;
    mean_first_s_ = time_s;
  }
  mean_sum_rad_ += angle_difference(offset, mean_reference_rad_);
  mean_last_s_ = time_s;
  ++mean_samples_;
}

void LevelledBuilder::use(const NavigationTick& tick, TickResult& result) {
  GatedRows& gated = gated_;
  const SightingAssociation& association = association_;
  if (tick.compass_rad && !std::isfinite(*tick.compass_rad))
    throw InvalidArgument("NavigationTick.compass_rad", *tick.compass_rad, "must be finite");
  const VehicleVector x = filter_.vehicle();
  for (const Pair& pair : association.pairs) {
    const SideScanRows rows =
        side_scan_rows(x, tick.sightings[at(pair.observation)], filter_.landmark_position(pair.prediction), config_.side_scan);
    StateRows block{rows.vehicle, pair.prediction, rows.H_landmark};
    gated.distances.push_back(filter_.squared_distance(block));
    gated.sensors.push_back(NavigationSensor::kSideScan);
    gated.rows.push_back(std::move(block));
    ++landmarks_[at(pair.prediction)].times_seen;
    seen_.push_back({pair.prediction, time_s_});
  }
  if (tick.frame) gate_frame(*tick.frame, result);
  for (const NavigationSensor sensor : gated.sensors) met_[static_cast<std::size_t>(sensor)] = true;
  const bool starts = time_s_ == start_time_s_ && landmarks_.empty();  // against a prior that is wide on purpose: no statistics
  for (std::size_t i = 0; i < gated.rows.size() && !starts; ++i) {
    SensorStatistics& of_sensor = statistics_[static_cast<std::size_t>(gated.sensors[i])];
    ++of_sensor.used;
    of_sensor.nis_sum += gated.distances[i];
    of_sensor.dof += static_cast<int>(gated.rows[i].rows());
  }
  result.update = filter_.update(gated.rows);
  level_again();
  if (tick.compass_rad && corrects_heading(config_.compass_use) && !offset_known_) {
    introduce_offset(*tick.compass_rad, config_.compass.sigma_rad);
  }
  if (tick.roll_pitch_rad) attitude_time_s_ = tick.time_s;
  if (tick.compass_rad && corrects_heading(config_.compass_use)) compass_time_s_ = tick.time_s;
  if (tick.compass_rad && config_.compass_use == CompassUse::kMean) add_to_mean(tick.time_s, *tick.compass_rad);
  for (const Eigen::Index i : association.fresh) {
    const SideScanSighting& sighting = tick.sightings[at(i)];
    const std::optional<SideScanLandmark> landmark = landmark_from_side_scan(filter_.vehicle(), sighting, config_.side_scan);
    if (!landmark) continue;
    filter_.add_landmark(*landmark);
    landmarks_.push_back({1, sighting.landmark_id, {static_cast<std::int64_t>(landmarks_.size())}});
    missed_.push_back(0);
    seen_.push_back({filter_.landmarks() - 1, time_s_});
    ++result.added;
  }
  result.paired = static_cast<int>(association.pairs.size());
  result.wrong_pairs = association.wrong_pairs;
  if (tick.frame) {
    result.paired += static_cast<int>(frame_->pairs.size());
    result.wrong_pairs += frame_->wrong_pairs;
    add_rays(*tick.frame, result);
    settle_rays();
  }
  if (tick.gyro_rad_s) {
    ++statistics_[static_cast<std::size_t>(NavigationSensor::kGyro)].used;
    gyro_rad_s_ = tick.gyro_rad_s;
    gyro_time_s_ = tick.time_s;
  }
  if (tick.time_s - last_step_s_ >= config_.trajectory_interval_s * (1.0 - 1e-9)) {
    journal_.step(tick.time_s, filter_);
    last_step_s_ = tick.time_s;
    result.remembered = true;
  }
}

std::optional<std::string> LevelledBuilder::reason_to_close_map(int new_landmarks) const {
  const bool can_begin = gated_.velocity_valid || !config_.split.needs_velocity_fix;
  if (fixes_.waits() && time_s_ - start_time_s_ >= kShortestFixedMapS && (can_begin || time_s_ - fixes_.kept_s() > kFixWaitsS))
    return "fix";
  if (!can_begin) return std::nullopt;
  if (was_silent_) return "silence";
  SplitSituation now;
  now.landmarks = static_cast<int>(landmarks_.size());
  now.new_landmarks = new_landmarks;
  const VehicleVector x = filter_.vehicle();
  const VehicleMatrix P = filter_.vehicle_covariance();
  constexpr std::array<Eigen::Index, 3> kPlanar{0, 1, 5};
  now.submap_T_vehicle = {Se2::from_vector(x(kPlanar)), P(kPlanar, kPlanar)};
  now.distance_m = distance_m_;
  now.duration_s = time_s_ - start_time_s_;
  const SplitPolicyConfig policy = split_policy();
  if (auto reason = reason_to_close(now, policy)) return reason;
  const std::optional<int>& most = policy.max_landmarks;
  // the tick that brought the last landmark had no velocity: the map was full and could not be closed
  if (most && now.landmarks > *most && distance_m_ > 0.0) return "landmarks";
  if (distance_m_ > config_.split.longest_m) return "distance";
  return std::nullopt;
}

std::optional<LevelledSubmap> LevelledBuilder::finish(const std::string& reason) {
  if (!started_) return std::nullopt;
  LevelledSubmap last = close(reason, nullptr);
  started_ = false;
  return last;
}

/// A camera shows more landmarks than a sonar does: with it, they are counted by its own limit.
SplitPolicyConfig LevelledBuilder::split_policy() const {
  SplitPolicyConfig policy = config_.split.policy;
  if (camera_ && policy.max_landmarks) policy.max_landmarks = config_.camera_association.max_landmarks;
  return policy;
}

/// The steps are left to whoever wants them, where there is a place for them and the configuration says so.
LevelledSubmap LevelledBuilder::close(const std::string& reason, std::optional<UnsmoothedSteps>* steps) {
  // no reading in this map: it says nothing of the offset but how it may have drifted, and so does not break the chain
  if (config_.compass_use == CompassUse::kFilter && !offset_known_) {
    introduce_offset(filter_.vehicle()(Layout::kAttitude + 2), kUnknownOffsetRad);
  }
  settle_map();
  LevelledSubmap map;
  map.index = index_++;
  map.start_time_s = start_time_s_;
  map.end_time_s = time_s_;
  map.closed_because = reason;
  std::vector<Eigen::Index> kept{Layout::kPosition, Layout::kPosition + 1, Layout::kAttitude + 2};
  if (offset_known_ && config_.compass_use == CompassUse::kFilter) {
    const bool drifts = config_.motion.compass_walk_rad_sqrt_s > 0.0;
    map.compass = drifts ? CompassPorts::kBorders : CompassPorts::kConstant;
    if (drifts) kept.push_back(Layout::kStartOffset);
    kept.push_back(Layout::kCompassOffset);
  } else if (config_.compass_use == CompassUse::kMean && mean_samples_ == 0) {  // as above: no reading, no word about the offset
    map.compass_mean = CompassMean{0.0, squared(kUnknownOffsetRad), 0.5 * (map.start_time_s + map.end_time_s)};
  } else if (mean_samples_ > 0) {
    const double duration_s = map.end_time_s - map.start_time_s;
    CompassMean mean;
    mean.offset_rad = wrap_angle(mean_reference_rad_ + mean_sum_rad_ / mean_samples_);
    const double gyro_walk = squared(config_.motion.gyro_sigma_rad_s) * config_.motion.gyro_step_s;
    mean.variance = squared(config_.compass.sigma_rad) / mean_samples_ +
                    (gyro_walk + squared(config_.motion.compass_walk_rad_sqrt_s)) * duration_s / 3.0;
    mean.time_s = 0.5 * (mean_first_s_ + mean_last_s_);
    map.compass_mean = mean;
  }
  if (map.index == 0) map.start_fix = start_fix_;
  map.exit_fix = fixes_.take(time_s_, filter_.vehicle(), filter_.vehicle_covariance());
  if (steps != nullptr && smoothing_ == StepSmoothing::kByCaller) {
    *steps = journal_.take_unsmoothed(filter_, kept, blank_ ? std::move(*blank_) : LevelledRecord(LevelledJournal::kMostBytes));
    blank_.reset();
  } else {
    map.steps = journal_.take_steps(filter_, kept);
  }
  for (Eigen::Index i = LevelledFilter::kVehicle; i < filter_.size(); ++i) kept.push_back(i);
  map.mean = filter_.mean()(kept);
  map.covariance = filter_.covariance()(kept, kept);
  map.covariance.topLeftCorner<3, 3>().diagonal().array() += kLeastVariance;
  if (map.compass == CompassPorts::kBorders) map.covariance(4, 4) += kLeastDriftVariance;
  map.landmarks = std::move(landmarks_);
  map.seen_s.resize(map.landmarks.size());
  for (const Seen& seen : seen_) map.seen_s[at(seen.landmark)].push_back(seen.time_s);
  landmarks_.clear();
  missed_.clear();
  seen_.clear();
  return map;
}

}  // namespace ssjs
