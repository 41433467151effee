#include "ssjs/pipeline/online_survey.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <string>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/whole_file.hpp"
#include "ssjs/joining/unsound_map.hpp"
#include "ssjs/pipeline/checkpoint_file.hpp"
#include "ssjs/pipeline/survey_factory.hpp"
#include "ssjs/pipeline/vehicle_in_world.hpp"

namespace ssjs {
namespace {

constexpr double kFarthestAhead_s = 60.0;
constexpr double kSteepest = 1.4;            // rad of pitch: the prediction ends before it means nothing
constexpr double kMostSteps = 1000.0;        // of one prediction, however far the clock has jumped
constexpr std::size_t kMostClosures = 1024;  // that wait
constexpr int kNoMap = -1;
constexpr const char* kNoState = "the submaps could not be joined: there is no state to write; the last checkpoint holds the one before";

const OnlineSurveyConfig& checked(const OnlineSurveyConfig& config) {
  throw_if_any(violations(config));
  if (config.slam.method != LevelledMethod::kPorts)
    throw InvalidArgument("method", "not ssjs", "what joins online ties submaps by their ports, in bounded steps: use ssjs");
  return config;
}

constexpr std::int64_t kMostCheckpointBytes = std::int64_t{8} << 30U;

CheckpointOwner owner(const OnlineSurveyConfig& config) { return {"online survey", field_texts(config)}; }

}  // namespace

OnlineSurvey::OnlineSurvey(const OnlineSurveyConfig& config)
    : config_(checked(config)),
      window_(config.arrival),
      builder_(local_config(config.slam), StepSmoothing::kByCaller),
      joiner_(joining_config(config.slam)),
      guard_(config.slam.guard) {}

Arrival OnlineSurvey::feed(const NavigationTick& sample) {
  if (finished_) throw InvalidArgument("sample", sample.time_s, "the mission is finished");
  const Arrival arrival = window_.put(sample);
  if (log_) tell_of_arrival(arrival, sample);
  while (const NavigationTick* const due = window_.take()) step(*due);
  ++arrivals_[static_cast<std::size_t>(arrival)];  // what throws before is not counted among them
  return arrival;
}

Arrival OnlineSurvey::feed(const TimedClosure& closure) {
  if (finished_) throw InvalidArgument("closure", closure.to_time_s, "the mission is finished");
  const Arrival arrival = [&] {
    try {
      check(closure);
    } catch (const Error&) {
      return Arrival::kNotFinite;
    }
    return closures_.size() < kMostClosures ? Arrival::kTaken : Arrival::kFlood;
  }();
  if (arrival == Arrival::kTaken) closures_.push_back(closure);
  ++arrivals_[static_cast<std::size_t>(arrival)];
  return arrival;
}

void OnlineSurvey::step(const NavigationTick& tick) {
  if (background_.has_job() && tick.time_s >= take_over_s_) take_over();
  watch_.see(tick);
  std::array<SensorStatistics, kNavigationSensors> before;
  const auto statistics = [&](std::size_t i) { return builder_.statistics(static_cast<NavigationSensor>(i)); };
  for (std::size_t i = 0; i < kNavigationSensors; ++i) before[i] = statistics(i);
  const NavigationTick& believed = guard_.pass(tick);
  if (guard_.astray_rad()) builder_.doubt_attitude(*guard_.astray_rad());
  TickResult local = builder_.feed(believed);
  ++steps_;
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    const SensorStatistics now = statistics(i);
    watch_.see(static_cast<NavigationSensor>(i), tick.time_s, now.used - before[i].used, now.refused - before[i].refused);
  }
  if (log_) tell_of_sensors();
  if (local.closed) close(local);
  const PortJoinerConfig& joining = config_.slam.joining;
  if (builder_.index() == 0 && builder_.offset_known() && joining.north_offset_rad) {
    global_T_base_ = base_facing_north(builder_.filter(), *joining.north_offset_rad, joining.north_offset_sigma_rad);
  }
  if (builder_.index() == 0 && builder_.start_fix()) {
    global_T_base_ = base_at_fix(global_T_base_, builder_.start_fix()->fix, joining.fixes.start_heading_sigma_rad);
  }
}

/// The new map stands at the end of the one before it until the background has found out better.
void OnlineSurvey::close(TickResult& finished) {
  if (background_.has_job()) take_over();  // closings follow each other faster than the delay
  LevelledSubmap& submap = *finished.closed;
  take_over_s_ = submap.end_time_s + config_.joining_delay_s;
  ++submaps_;
  const auto exit_of = [](const LevelledSubmap& map) { return GaussianSe2{map.base_T_exit(), map.covariance.topLeftCorner<3, 3>()}; };
  global_T_base_ = compose_independent(global_T_base_, is_sound(submap) ? exit_of(submap) : exit_of(without_knowledge(submap)));
  if (!join_failure_.empty()) {
    if (finished.steps) builder_.reuse(std::move(finished.steps->record));
    return;
  }
  const auto is_due = [&](const TimedClosure& closure) { return closure.to_time_s <= submap.end_time_s; };
  const auto later = std::stable_partition(closures_.begin(), closures_.end(), is_due);
  std::vector<TimedClosure> due(closures_.begin(), later);
  closures_.erase(closures_.begin(), later);
  joining_.submap = std::move(submap);
  joining_.steps = std::move(finished.steps);
  const auto done = std::make_shared<std::promise<void>>();
  is_joined_ = done->get_future().share();
  background_.start([this, done, due = std::move(due), read = is_read_] {
    if (read.valid()) read.wait();
    try {
      if (joining_.steps) joining_.submap.steps = joining_.steps->smoothed();
      joining_.report = joiner_.take(std::move(joining_.submap));
      joining_.report.append(propose(due));
      joining_.global_T_newest_base = joiner_.global_T_newest_base();
      done->set_value();
    } catch (...) {
      done->set_exception(std::current_exception());
      throw;
    }
  });
}

/// Between bases now: one whose moments no remembered step is near has nothing to hold on to.
JoinReport OnlineSurvey::propose(const std::vector<TimedClosure>& claimed) {
  JoinReport report;
  std::vector<Closure> closures;
  for (const TimedClosure& closure : claimed) {
    if (std::optional<Closure> found = between_bases(closure, joiner_.maps())) {
      closures.push_back(std::move(*found));
      continue;
    }
    LoopAttempt nowhere;
    nowhere.time_s = closure.to_time_s;
    nowhere.from = nowhere.to = kNoMap;
    nowhere.reason = "no two submaps lie at " + std::to_string(closure.from_time_s) + " s and " + std::to_string(closure.to_time_s) + " s";
    nowhere.source = closure.source;
    report.loops.push_back(nowhere);
  }
  report.append(joiner_.propose(closures));
  return report;
}

void OnlineSurvey::fail_to_join(const std::string& problem) {
  join_failure_ = problem;
  joining_.steps.reset();
  closures_.clear();
  tell(NoteKind::kFailure, "the submaps are no longer joined, and follow each other by dead reckoning: " + problem);
}

bool OnlineSurvey::is_joined() {
  rest();
  if (!join_failure_.empty()) return false;
  if (!is_joined_.valid()) return true;
  try {
    is_joined_.get();
  } catch (const std::exception&) {
    return false;  // taking over will say so
  }
  return true;
}

void OnlineSurvey::count(const JoinReport& report) {
  if (report.unsound > 0) tell(NoteKind::kFailure, "the filter lost its footing: nothing of the submap that ended is believed");
  for (const LoopAttempt& loop : report.loops) {
    if (loop.accepted) {
      ++loop_closures_;
      continue;
    }
    ++closures_refused_;
    if (loop.from == kNoMap) {
      tell(NoteKind::kClosure, "closure refused: " + loop.reason);
      continue;
    }
    if (loop.revised) --loop_closures_;
    tell(NoteKind::kClosure, "closure of map " + std::to_string(loop.from) + " with map " + std::to_string(loop.to) +
                                 (loop.revised ? " taken back: " : " refused: ") + loop.reason);
  }
  for (const FixAttempt& fix : report.fixes) {
    (fix.accepted ? fixes_used_ : fixes_refused_) += 1;
    relocations_ += fix.relocated ? 1 : 0;
    fixes_contradict_ = !fix.accepted;
    watch_.see(NavigationSensor::kFix, fix.time_s, fix.accepted ? 1 : 0, 0);
    const std::string off = std::to_string(std::lround(fix.distance_m)) + " m from where the vehicle was thought to be";
    if (!fix.accepted) tell(NoteKind::kFix, "fix refused, " + fix.reason + ": " + off);
    if (fix.relocated) tell(NoteKind::kRelocation, "the estimate was wrong and goes on from the fixes, " + off);
  }
}

void OnlineSurvey::tell(NoteKind kind, const std::string& text) const {
  if (log_) log_({kind, builder_.time_s(), text});
}

void OnlineSurvey::tell_of_arrival(Arrival arrival, const NavigationTick& sample) {
  if (window_.clock_changes() > told_clock_changes_) {
    tell(NoteKind::kClock,
         "the clock of the samples was set; " + std::to_string(window_.clock_offset_s()) + " s are added to their stamps");
    told_clock_changes_ = window_.clock_changes();
  }
  const bool is_news = arrival != told_arrival_;
  told_arrival_ = arrival;
  if (!is_news || arrival == Arrival::kTaken) return;
  const char* const what = arrival == Arrival::kLate        ? "samples come later than the window allows and are refused"
                           : arrival == Arrival::kDuplicate ? "a sensor speaks twice at one time; the second is refused"
                           : arrival == Arrival::kNotFinite ? "samples that are no numbers are refused"
                           : arrival == Arrival::kClockJump ? "a stamp far ahead of all others: refused until others follow"
                                                            : "more samples than the window holds: refused";
  tell(arrival == Arrival::kClockJump ? NoteKind::kClock : NoteKind::kArrival, what + (" (stamp " + std::to_string(sample.time_s) + " s)"));
}

SensorState OnlineSurvey::state_of(NavigationSensor sensor) const {
  if (sensor == NavigationSensor::kFix && fixes_contradict_) return SensorState::kRefused;
  return watch_.state(sensor, builder_.time_s(), config_.silence_s, guard_);
}

void OnlineSurvey::tell_of_sensors() {
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    const auto sensor = static_cast<NavigationSensor>(i);
    const SensorState now = state_of(sensor);
    const SensorState before = std::exchange(told_[i], now);
    const bool came = before == SensorState::kUnheard && now == SensorState::kGood;
    if (now == before || came || sensor == NavigationSensor::kFix) continue;  // of fixes more is said when they are held against the map
    const std::string advice = advice_for(sensor, now);
    tell(NoteKind::kSensor, advice.empty() ? std::string(name_of(sensor)) + " is good again" : advice);
  }
}

void OnlineSurvey::take_over() {
  if (!background_.is_done()) ++waits_;
  try {
    background_.collect();
  } catch (const std::exception& problem) {
    fail_to_join(problem.what());
    return;
  }
  if (joining_.steps) builder_.reuse(std::move(joining_.steps->record));
  joining_.steps.reset();
  count(joining_.report);
  compass_jumps_ = joiner_.compass_jumps();
  global_T_base_ = joining_.global_T_newest_base;
}

std::optional<SurveyStep> OnlineSurvey::global_T_vehicle() const {
  if (!started()) return std::nullopt;
  VehicleVector x = builder_.filter().vehicle();
  VehicleMatrix P = builder_.filter().vehicle_covariance();
  double time_s = builder_.time_s();
  std::optional<Eigen::Vector3d> rates = builder_.gyro_rad_s();
  double rates_s = time_s;
  const auto predict_to = [&](double until_s) {
    ConstantVelocityConfig motion = config_.slam.local.motion;
    const bool gyro_speaks = rates && until_s - rates_s <= kGyroHolds * motion.gyro_step_s;
    if (motion.drive == RotationDrive::kGyro && !gyro_speaks) motion.drive = RotationDrive::kConstantAttitude;
    const double step_s = std::max(config_.slam.local.max_step_s, (until_s - time_s) / kMostSteps);
    while (time_s < until_s && std::abs(x(VehicleLayout::kAttitude + 1)) < kSteepest) {
      const double dt = std::min(until_s - time_s, step_s);
      const VehiclePrediction ahead = predict_constant_velocity(x, rates.value_or(Eigen::Vector3d::Zero()), dt, motion);
      x = ahead.state;
      P = (ahead.F * P * ahead.F.transpose() + ahead.Q).eval();
      time_s = until_s - time_s <= dt ? until_s : time_s + dt;
    }
  };
  for (const auto& [sample_s, waiting] : window_.waiting()) {
    if (sample_s - time_s > kFarthestAhead_s) break;  // after a silence the filter has to speak first
    predict_to(sample_s);
    const bool is_believed = waiting.gyro_rad_s && waiting.gyro_rad_s->cwiseAbs().maxCoeff() <= config_.slam.guard.max_turn_rate_rad_s &&
                             guard_.fault(NavigationSensor::kGyro) == SampleFault::kNone;
    if (!is_believed) continue;
    rates = waiting.gyro_rad_s;
    rates_s = sample_s;
  }
  return vehicle_in_world(global_T_base_, x, P.topLeftCorner<6, 6>(), time_s);
}

SurveyStatus OnlineSurvey::status() const {
  SurveyStatus status;
  status.arrivals = arrivals_;
  status.submaps = submaps_;
  status.loop_closures = loop_closures_;
  status.closures_refused = closures_refused_;
  status.compass_jumps = compass_jumps_;
  status.relocations = relocations_;
  status.clock_changes = window_.clock_changes();
  status.clock_offset_s = window_.clock_offset_s();
  status.waits = waits_;
  status.joining = !background_.is_done();
  status.landmarks = static_cast<int>(builder_.filter().landmarks());
  status.silent_for_s.fill(-1.0);
  if (!started()) return status;
  bool all_good = true;
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    const auto sensor = static_cast<NavigationSensor>(i);
    const SensorStatistics& statistics = builder_.statistics(sensor);
    status.used[i] = statistics.used;
    status.refused[i] = statistics.refused + guard_.refused(sensor);
    status.silent_for_s[i] = watch_.unused_s(sensor, builder_.time_s());
    status.sensors[i] = state_of(sensor);
    const bool unused = speaks_always(sensor) && status.silent_for_s[i] > config_.silence_s;
    const bool bad = status.sensors[i] != SensorState::kGood && status.sensors[i] != SensorState::kUnheard;
    all_good = all_good && !unused && !bad;
    if (unused && !bad) status.sensors[i] = SensorState::kRefused;
    const bool is_worst = status.advice.empty() || sensor == NavigationSensor::kVelocityLog;  // nothing costs more than its loss
    if (std::string advice = advice_for(sensor, status.sensors[i]); !advice.empty() && is_worst) status.advice = std::move(advice);
  }
  status.used[static_cast<std::size_t>(NavigationSensor::kFix)] = fixes_used_;
  status.refused[static_cast<std::size_t>(NavigationSensor::kFix)] = fixes_refused_;
  status.position_sigma_m = largest_sigma(global_T_vehicle()->covariance.topLeftCorner<2, 2>());
  const bool lost = !(status.position_sigma_m <= config_.lost_sigma_m);
  if (lost) status.advice = "the position is hardly known: surface for a fix, or set the pose";
  if (!join_failure_.empty()) {
    all_good = false;
    status.advice = "the submaps are no longer joined: restore the last checkpoint, or surface for fixes";
  }
  status.health = lost ? SurveyHealth::kLost : all_good ? SurveyHealth::kGood : SurveyHealth::kDegraded;
  return status;
}

void OnlineSurvey::finish_once() {
  while (const NavigationTick* const due = window_.take(true)) step(*due);
  if (background_.has_job()) take_over();
  finished_ = true;
  rest();
  std::optional<LevelledSubmap> last = builder_.finish("end");
  if (last) ++submaps_;
  if (join_failure_.empty()) {
    try {
      if (last) count(joiner_.take(std::move(*last)));
      count(propose({closures_.begin(), closures_.end()}));
      closures_.clear();
      if (!joiner_.maps().empty()) count(joiner_.finish());
    } catch (const std::exception& problem) {
      fail_to_join(problem.what());
    }
  }
}

void OnlineSurvey::finish() {
  if (!finished_) finish_once();
  if (!join_failure_.empty()) throw Error("the submaps could not be joined: " + join_failure_);
}

/// What the maps say is asked of them when the background rests.
void OnlineSurvey::rest() {
  for (const std::shared_future<void>& work : {is_joined_, is_read_}) {
    if (work.valid()) work.wait();
  }
}

std::vector<SurveyLandmark> OnlineSurvey::landmarks() {
  if (!is_joined()) return {};
  return landmarks_in_world(joiner_.maps(), joiner_.level());
}

std::vector<SurveyStep> OnlineSurvey::trajectory() {
  std::vector<SurveyStep> trajectory;
  if (!is_joined()) return trajectory;
  for (const PortMap& map : joiner_.maps()) {
    const std::vector<SurveyStep> steps = steps_in_world(map, joiner_.level());
    trajectory.insert(trajectory.end(), steps.begin(), steps.end());
  }
  return trajectory;
}

void OnlineSurvey::archive_joiner(Archive& a, bool joining) {
  a("joiner", joiner_);
  if (joining) a("joining", joining_);
}

void OnlineSurvey::read(Archive& a) {
  bool joining = false;
  archive(a);
  a("joining", joining);
  archive_joiner(a, joining);
  a.end();
  if (submaps_ < 0 || static_cast<std::size_t>(submaps_) != joiner_.maps().size() || (!finished_ && submaps_ != builder_.index())) {
    throw InvalidArgument("submaps", submaps_, "must be those of the joiner");
  }
  if (joining) background_.start([] {});  // done, and to be taken over
}

std::string OnlineSurvey::checkpoint() {
  if (!is_joined()) throw Error(kNoState);
  Archive a;
  bool joining = background_.has_job();
  archive(a);
  a("joining", joining);
  archive_joiner(a, joining);
  return seal_checkpoint(owner(config_), a.take_bytes(), "");
}

bool OnlineSurvey::checkpoint(const std::string& path) {
  if (writing_.valid()) {
    if (writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    writing_.get();
  }
  if (!join_failure_.empty()) throw Error(kNoState);
  Archive now;
  now.reserve(bytes_before_ + bytes_before_ / 4);
  bool joining = background_.has_job();
  archive(now);
  now("joining", joining);
  std::string own = now.take_bytes();
  bytes_before_ = own.size();
  std::promise<void> read;
  is_read_ = read.get_future().share();
  writing_ =
      std::async(std::launch::async, [this, path, joining, joined = is_joined_, own = std::move(own), read = std::move(read)]() mutable {
        Archive a;
        try {
          if (joined.valid()) joined.get();
          archive_joiner(a, joining);
        } catch (...) {
          read.set_value();
          throw;
        }
        read.set_value();
        write_whole_file(path, seal_checkpoint(owner(config_), own, a.take_bytes()));
      });
  return true;
}

void OnlineSurvey::wait_for_checkpoint() {
  if (writing_.valid()) writing_.get();
}

std::unique_ptr<OnlineSurvey> OnlineSurvey::restored(const OnlineSurveyConfig& config, std::string_view bytes, const std::string& source) {
  auto survey = std::make_unique<OnlineSurvey>(config);
  Archive a(open_checkpoint(owner(config), bytes, source), source);
  try {
    survey->read(a);
  } catch (const FileError&) {
    throw;
  } catch (const std::exception& problem) {
    throw FileError(source, 0, std::string("holds a state that cannot be: ") + problem.what());
  }
  return survey;
}

std::unique_ptr<OnlineSurvey> OnlineSurvey::restored_from(const OnlineSurveyConfig& config, const std::string& path) {
  return restored(config, read_whole_file(path, kMostCheckpointBytes), path);
}

}  // namespace ssjs
