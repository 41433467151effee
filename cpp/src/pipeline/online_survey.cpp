#include "ssjs/pipeline/online_survey.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include "ssjs/base/error.hpp"
#include "ssjs/base/whole_file.hpp"
#include "ssjs/pipeline/checkpoint_file.hpp"
#include "ssjs/pipeline/survey_factory.hpp"
#include "ssjs/pipeline/vehicle_in_world.hpp"

namespace ssjs {
namespace {

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
      joiner_(joining_config(config.slam)) {
  heard_s_.fill(-1.0);
}

Arrival OnlineSurvey::feed(const NavigationTick& sample) {
  if (finished_) throw InvalidArgument("sample", sample.time_s, "the mission is finished");
  const Arrival arrival = window_.put(sample);
  ++arrivals_[static_cast<std::size_t>(arrival)];
  while (const NavigationTick* const due = window_.take()) step(*due);
  return arrival;
}

void OnlineSurvey::step(const NavigationTick& tick) {
  if (background_.has_job() && tick.time_s >= take_over_s_) take_over();
  std::array<int, kNavigationSensors> used_before{};
  for (std::size_t i = 0; i < kNavigationSensors; ++i) used_before[i] = builder_.statistics(static_cast<NavigationSensor>(i)).used;
  TickResult local = builder_.feed(tick);
  ++steps_;
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    if (builder_.statistics(static_cast<NavigationSensor>(i)).used > used_before[i]) heard_s_[i] = tick.time_s;
  }
  if (local.closed) close(local);
  const PortJoinerConfig& joining = config_.slam.joining;
  if (builder_.index() == 0 && builder_.offset_known() && joining.north_offset_rad) {
    global_T_base_ = base_facing_north(builder_.filter(), *joining.north_offset_rad, joining.north_offset_sigma_rad);
  }
}

/// The new map stands at the end of the one before it until the background has found out better.
void OnlineSurvey::close(TickResult& finished) {
  if (background_.has_job()) take_over();  // closings follow each other faster than the delay
  LevelledSubmap& submap = *finished.closed;
  take_over_s_ = submap.end_time_s + config_.joining_delay_s;
  ++submaps_;
  global_T_base_ = compose_independent(global_T_base_, {submap.base_T_exit(), submap.covariance.topLeftCorner<3, 3>()});
  joining_.submap = std::move(submap);
  joining_.steps = std::move(finished.steps);
  const auto done = std::make_shared<std::promise<void>>();
  is_joined_ = done->get_future().share();
  background_.start([this, done, read = is_read_] {
    if (read.valid()) read.wait();
    try {
      if (joining_.steps) joining_.submap.steps = joining_.steps->smoothed();
      joining_.report = joiner_.take(std::move(joining_.submap));
      joining_.global_T_newest_base = joiner_.global_T_newest_base();
      done->set_value();
    } catch (...) {
      done->set_exception(std::current_exception());
      throw;
    }
  });
}

void OnlineSurvey::take_over() {
  if (!background_.is_done()) ++waits_;
  background_.collect();
  if (joining_.steps) builder_.reuse(std::move(joining_.steps->record));
  joining_.steps.reset();
  for (const LoopAttempt& loop : joining_.report.loops) loop_closures_ += loop.accepted ? 1 : 0;
  compass_jumps_ = joiner_.compass_jumps();
  global_T_base_ = joining_.global_T_newest_base;
}

std::optional<SurveyStep> OnlineSurvey::global_T_vehicle() const {
  if (!started()) return std::nullopt;
  VehicleVector x = builder_.filter().vehicle();
  VehicleMatrix P = builder_.filter().vehicle_covariance();
  double time_s = builder_.time_s();
  std::optional<Eigen::Vector3d> rates = builder_.gyro_rad_s();
  const auto predict_to = [&](double until_s) {
    ConstantVelocityConfig motion = config_.slam.local.motion;
    if (motion.drive == RotationDrive::kGyro && !rates) motion.drive = RotationDrive::kConstantAttitude;
    while (time_s < until_s) {
      const double dt = std::min(until_s - time_s, config_.slam.local.max_step_s);
      const VehiclePrediction ahead = predict_constant_velocity(x, rates.value_or(Eigen::Vector3d::Zero()), dt, motion);
      x = ahead.state;
      P = (ahead.F * P * ahead.F.transpose() + ahead.Q).eval();
      time_s = until_s - time_s <= dt ? until_s : time_s + dt;
    }
  };
  for (const auto& [sample_s, waiting] : window_.waiting()) {
    predict_to(sample_s);
    if (waiting.gyro_rad_s) rates = waiting.gyro_rad_s;
  }
  return vehicle_in_world(global_T_base_, x, P.topLeftCorner<6, 6>(), time_s);
}

SurveyStatus OnlineSurvey::status() const {
  SurveyStatus status;
  status.arrivals = arrivals_;
  status.submaps = submaps_;
  status.loop_closures = loop_closures_;
  status.compass_jumps = compass_jumps_;
  status.waits = waits_;
  status.joining = !background_.is_done();
  status.landmarks = static_cast<int>(builder_.filter().landmarks());
  status.silent_for_s.fill(-1.0);
  if (!started()) return status;
  bool all_speak = true;
  for (std::size_t i = 0; i < kNavigationSensors; ++i) {
    const auto sensor = static_cast<NavigationSensor>(i);
    const SensorStatistics& statistics = builder_.statistics(sensor);
    status.used[i] = statistics.used;
    status.refused[i] = statistics.refused;
    if (heard_s_[i] < 0.0) continue;
    status.silent_for_s[i] = builder_.time_s() - heard_s_[i];
    if (sensor != NavigationSensor::kSideScan) all_speak = all_speak && status.silent_for_s[i] <= config_.silence_s;
  }
  status.position_sigma_m = largest_sigma(global_T_vehicle()->covariance.topLeftCorner<2, 2>());
  const bool lost = !(status.position_sigma_m <= config_.lost_sigma_m);
  status.health = lost ? SurveyHealth::kLost : all_speak ? SurveyHealth::kGood : SurveyHealth::kDegraded;
  return status;
}

void OnlineSurvey::finish() {
  if (finished_) return;
  while (const NavigationTick* const due = window_.take(true)) step(*due);
  if (background_.has_job()) take_over();
  finished_ = true;
  rest();
  if (std::optional<LevelledSubmap> last = builder_.finish("end")) {
    const JoinReport report = joiner_.take(std::move(*last));
    for (const LoopAttempt& loop : report.loops) loop_closures_ += loop.accepted ? 1 : 0;
    ++submaps_;
  }
  if (!joiner_.maps().empty()) joiner_.finish();
}

/// What the maps say is asked of them when the background rests.
void OnlineSurvey::rest() {
  for (const std::shared_future<void>& work : {is_joined_, is_read_}) {
    if (work.valid()) work.wait();
  }
}

std::vector<SurveyLandmark> OnlineSurvey::landmarks() {
  rest();
  return landmarks_in_world(joiner_.maps(), joiner_.level());
}

std::vector<SurveyStep> OnlineSurvey::trajectory() {
  rest();
  std::vector<SurveyStep> trajectory;
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
  if (submaps_ < 0 || static_cast<std::size_t>(submaps_) != joiner_.maps().size()) {
    throw InvalidArgument("submaps", submaps_, "must be those of the joiner");
  }
  if (joining) background_.start([] {});  // done, and to be taken over
}

std::string OnlineSurvey::checkpoint() {
  rest();
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
  Archive now;
  bool joining = background_.has_job();
  archive(now);
  now("joining", joining);
  std::promise<void> read;
  is_read_ = read.get_future().share();
  writing_ =
      std::async(std::launch::async, [this, path, joining, joined = is_joined_, own = now.take_bytes(), read = std::move(read)]() mutable {
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
  } catch (const Error& problem) {
    throw FileError(source, 0, std::string("holds a state that cannot be: ") + problem.what());
  }
  return survey;
}

std::unique_ptr<OnlineSurvey> OnlineSurvey::restored_from(const OnlineSurveyConfig& config, const std::string& path) {
  return restored(config, read_whole_file(path, kMostCheckpointBytes), path);
}

}  // namespace ssjs
