#include "ssjs/embed/online.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ssjs/base/config_text.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/base/version.hpp"
#include "ssjs/pipeline/online_survey.hpp"

namespace ssjs::online {
inline namespace v1 {
namespace {

static_assert(kSensors < kNavigationSensors);  // the camera, the last of them, is not part of this interface
static_assert(static_cast<int>(SensorState::kWrongUnit) == static_cast<int>(ssjs::SensorState::kWrongUnit));
static_assert(static_cast<int>(Note::kFailure) == static_cast<int>(NoteKind::kFailure));
static_assert(static_cast<int>(Sensor::kGyro) == static_cast<int>(NavigationSensor::kGyro));
static_assert(static_cast<int>(Arrival::kFlood) == static_cast<int>(ssjs::Arrival::kFlood));
static_assert(static_cast<int>(Health::kLost) == static_cast<int>(SurveyHealth::kLost));

template <class Matrix>
void put_rows(const Matrix& matrix, double* out) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) *out++ = matrix(i, j);
  }
}

/// As much of it as fits.
void put_text(const char* text, char* out, std::size_t size) noexcept {
  std::size_t i = 0;
  for (; text[i] != '\0' && i + 1 < size; ++i) out[i] = text[i];
  out[i] = '\0';
}

Pose pose_of(const SurveyStep& step) {
  const auto& x = step.global_T_vehicle;
  Pose pose{step.time_s, x(0), x(1), x(2), x(3), x(4), x(5), {}};
  put_rows(step.covariance, pose.covariance);
  return pose;
}

Landmark landmark_of(const SurveyLandmark& landmark) {
  Landmark out{landmark.position.x(),        landmark.position.y(),
               landmark.position.z(),        {},
               landmark.landmark.times_seen, static_cast<std::int32_t>(landmark.maps.size())};
  put_rows(landmark.covariance, out.covariance);
  return out;
}

OnlineSurveyConfig configured(const Setting* settings, std::size_t count) {
  OnlineSurveyConfig config;
  for (std::size_t i = 0; i < count; ++i) set_field(config, settings[i].key, settings[i].value);
  return config;
}

}  // namespace

class Estimator::Inside {
 public:
  explicit Inside(std::unique_ptr<OnlineSurvey> whole) : owned_(std::move(whole)), survey(*owned_) {}

  /// `action`, or `otherwise` and its message where it throws.
  template <class Result, class Action>
  Result guarded(Result otherwise, const Action& action) noexcept {
    try {
      return action();
    } catch (const std::exception& problem) {
      remember(problem.what());
    } catch (...) {
      remember("an exception of an unknown kind");
    }
    return otherwise;
  }

  template <class Sample>
  Arrival feed(const Sample& sample) noexcept {
    const Arrival arrival = guarded(Arrival::kFailed, [&] { return static_cast<Arrival>(survey.feed(sample)); });
    if (arrival == Arrival::kFailed) ++failures;
    return arrival;
  }

  /// `maker`'s survey, or nothing and its complaint.
  template <class Maker>
  Inside* another(const Maker& maker) noexcept {
    return guarded(static_cast<Inside*>(nullptr), [&] { return std::make_unique<Inside>(maker()).release(); });
  }

 private:
  std::unique_ptr<OnlineSurvey> owned_;

 public:
  OnlineSurvey& survey;
  NavigationTick sighted;  ///< one sighting; its memory serves the next
  std::int64_t failures = 0;
  std::array<char, 512> error{};

 private:
  void remember(const char* text) noexcept { put_text(text, error.data(), error.size()); }
};

Estimator::Estimator(const Setting* settings, std::size_t count) : inside_(nullptr) {
  try {
    inside_ = new Inside(std::make_unique<OnlineSurvey>(configured(settings, count)));
  } catch (const Error& problem) {
    throw std::invalid_argument(problem.what());
  }
}

Estimator::~Estimator() { delete inside_; }
Estimator::Estimator(Estimator&& other) noexcept : inside_(std::exchange(other.inside_, nullptr)) {}
Estimator& Estimator::operator=(Estimator&& other) noexcept {
  std::swap(inside_, other.inside_);
  return *this;
}

Arrival Estimator::feed(const Gyro& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.gyro_rad_s = Eigen::Map<const Eigen::Vector3d>(sample.rates_rad_s);
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Attitude& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.roll_pitch_rad = Eigen::Vector2d(sample.roll_rad, sample.pitch_rad);
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Compass& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.compass_rad = sample.heading_rad;
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Depth& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.depth_m = sample.depth_m;
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Altitude& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.altitude_m = sample.altitude_m;
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Velocity& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.velocity = VelocitySample{Eigen::Map<const Eigen::Vector3d>(sample.velocity_m_s), sample.bottom_lock, std::nullopt};
  return inside_->feed(tick);
}

Arrival Estimator::feed(const Sighting& sample) noexcept {
  return inside_->guarded(Arrival::kFailed, [&] {
    NavigationTick& tick = inside_->sighted;
    tick.time_s = sample.time_s;
    tick.sightings.resize(1);
    SideScanSighting& sighting = tick.sightings.front();
    sighting = {};
    sighting.vehicle_p_point = Eigen::Map<const Eigen::Vector3d>(sample.position_m);
    if (sample.has_covariance) sighting.covariance = Eigen::Map<const Eigen::Matrix3d>(sample.covariance_m2);
    if (sample.landmark_id >= 0) sighting.landmark_id = sample.landmark_id;
    return inside_->feed(tick);
  });
}

Arrival Estimator::feed(const Fix& sample) noexcept {
  NavigationTick tick = tick_at(sample.time_s);
  tick.fix = PositionFix{{sample.x_m, sample.y_m}, Eigen::Map<const Eigen::Matrix2d>(sample.covariance_m2), sample.set_pose};
  return inside_->feed(tick);
}

Arrival Estimator::feed(const LoopClosure& closure) noexcept {
  return inside_->guarded(Arrival::kFailed, [&] {
    using Covariance = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Se2 from_T_to = Se2::from_vector({closure.x_m, closure.y_m, closure.yaw_rad});
    return inside_->feed(
        TimedClosure{closure.from_time_s, closure.to_time_s, {from_T_to, Eigen::Map<const Covariance>(closure.covariance)}});
  });
}

bool Estimator::pose(Pose* out) const noexcept {
  return inside_->guarded(false, [&] {
    const std::optional<SurveyStep> step = inside_->survey.global_T_vehicle();
    if (step) *out = pose_of(*step);
    return step.has_value();
  });
}

Status Estimator::status() const noexcept {
  return inside_->guarded(Status{}, [&] {
    const SurveyStatus now = inside_->survey.status();
    Status out{};
    out.health = static_cast<Health>(now.health);
    out.position_sigma_m = now.position_sigma_m;
    std::copy(now.arrivals.begin(), now.arrivals.end(), out.arrivals);
    out.arrivals[static_cast<std::size_t>(Arrival::kFailed)] = inside_->failures;
    std::copy(now.silent_for_s.begin(), now.silent_for_s.end(), out.silent_for_s);
    std::copy(now.used.begin(), now.used.end(), out.used);
    std::copy(now.refused.begin(), now.refused.end(), out.refused);
    out.submaps = now.submaps;
    out.landmarks = now.landmarks;
    out.loop_closures = now.loop_closures;
    out.compass_jumps = now.compass_jumps;
    out.relocations = now.relocations;
    for (std::size_t i = 0; i < kSensors; ++i) out.sensors[i] = static_cast<SensorState>(now.sensors[i]);
    put_text(now.advice.c_str(), out.advice, kAdviceLength);
    out.clock_changes = now.clock_changes;
    out.clock_offset_s = now.clock_offset_s;
    out.waits = now.waits;
    out.joining = now.joining;
    out.closures_refused = now.closures_refused;
    return out;
  });
}

void Estimator::set_log(LogCallback callback, void* context) noexcept {
  (void)inside_->guarded(false, [&] {
    SurveyLog log;
    if (callback != nullptr) {
      log = [=](const SurveyNote& note) { callback(context, static_cast<Note>(note.kind), note.time_s, note.text.c_str()); };
    }
    inside_->survey.set_log(std::move(log));
    return true;
  });
}

bool Estimator::finish() noexcept {
  return inside_->guarded(false, [&] {
    inside_->survey.finish();
    return true;
  });
}

std::size_t Estimator::landmarks(Landmark* out, std::size_t capacity) noexcept {
  return inside_->guarded(std::size_t{0}, [&] {
    const std::vector<SurveyLandmark> all = inside_->survey.landmarks();
    for (std::size_t i = 0; i < std::min(capacity, all.size()); ++i) out[i] = landmark_of(all[i]);
    return all.size();
  });
}

std::size_t Estimator::trajectory(Pose* out, std::size_t capacity) noexcept {
  return inside_->guarded(std::size_t{0}, [&] {
    const std::vector<SurveyStep> all = inside_->survey.trajectory();
    for (std::size_t i = 0; i < std::min(capacity, all.size()); ++i) out[i] = pose_of(all[i]);
    return all.size();
  });
}

bool Estimator::checkpoint(const char* path) noexcept {
  return inside_->guarded(false, [&] {
    if (inside_->survey.checkpoint(path)) return true;
    throw Error(std::string(path) + ": the checkpoint before is still being written");
  });
}

bool Estimator::wait_for_checkpoint() noexcept {
  return inside_->guarded(false, [&] {
    inside_->survey.wait_for_checkpoint();
    return true;
  });
}

std::size_t Estimator::checkpoint(void* out, std::size_t capacity) noexcept {
  return inside_->guarded(std::size_t{0}, [&] {
    const std::string bytes = inside_->survey.checkpoint();
    if (bytes.size() <= capacity) std::copy(bytes.begin(), bytes.end(), static_cast<char*>(out));
    return bytes.size();
  });
}

bool Estimator::become(Inside* found) noexcept {
  if (found == nullptr) return false;
  static_cast<void>(inside_->guarded(false, [&] {
    found->survey.set_log(inside_->survey.log());
    return true;
  }));
  delete std::exchange(inside_, found);
  return true;
}

bool Estimator::restore(const char* path) noexcept {
  Inside* const found = inside_->another([&] { return OnlineSurvey::restored_from(inside_->survey.config(), path); });
  return become(found);
}

bool Estimator::restore(const void* bytes, std::size_t size) noexcept {
  const std::string_view all(static_cast<const char*>(bytes), size);
  Inside* const found = inside_->another([&] { return OnlineSurvey::restored(inside_->survey.config(), all, "checkpoint"); });
  return become(found);
}

const char* Estimator::last_error() const noexcept { return inside_->error.data(); }

const char* version() noexcept { return kVersion.data(); }

}  // namespace v1
}  // namespace ssjs::online
