/// SLAM inside the vehicle: feed samples as they come, read pose, covariance and health at any time. The one header of the shared library
/// ssjs::online and the only interface under an ABI promise: plain structs and fixed arrays, no Eigen, no other header of this project.
/// docs/embedding.md has the loop, the threads, the timing and the frames.
///
/// Frames: x north (or ahead at the start), y to starboard of it, z down; body x forward, y starboard, z down. Roll positive with starboard
/// down, pitch with the bow up, yaw clockwise. m, rad, s. Covariances row-major, of (x, y, z, roll, pitch, yaw) added to the estimate.
///
/// Threads: an Estimator belongs to one thread at a time; two of them share nothing. It starts a thread with its first submap, which works
/// whenever one is finished. No global state, no output, no exceptions but from the constructor.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(_WIN32)
#define SSJS_ONLINE_API
#else
#define SSJS_ONLINE_API __attribute__((visibility("default")))
#endif

namespace ssjs::online {
inline namespace v1 {

struct Gyro {
  double time_s;
  double rates_rad_s[3];  ///< body axes
};
struct Attitude {
  double time_s, roll_rad, pitch_rad;
};
struct Compass {
  double time_s, heading_rad;
};
struct Depth {
  double time_s, depth_m;
};
struct Altitude {
  double time_s, altitude_m;
};
struct Velocity {
  double time_s;
  double velocity_m_s[3];  ///< axes of the velocity log
  bool bottom_lock;        ///< false: not over the ground, never used
};
/// A point on the seabed seen from the vehicle.
struct Sighting {
  double time_s;
  double position_m[3];  ///< body frame
  bool has_covariance;
  double covariance_m2[9];
  std::int64_t landmark_id;  ///< where the source knows it, else -1
};

/// A position in the world: satellites at the surface, or the word of an operator.
struct Fix {
  double time_s;
  double x_m, y_m;
  double covariance_m2[4];  ///< positive definite
  bool set_pose;            ///< an operator's: believed whatever was expected
};

/// A loop closure from elsewhere, an acoustic or an optical place recogniser: where the vehicle was at to_time_s, seen from where it was at
/// from_time_s, both levelled. Those that contradict others that agree are refused.
struct LoopClosure {
  double from_time_s, to_time_s;  ///< the second later
  double x_m, y_m, yaw_rad;       ///< ahead, to starboard, clockwise
  double covariance[9];           ///< of x, y, yaw; positive definite, independent of all else
};

/// What became of a sample.
enum class Arrival : std::int32_t {
  kTaken = 0,
  kLate = 1,       ///< older than the window: refused
  kDuplicate = 2,  ///< this sensor has spoken at that very time
  kNotFinite = 3,  ///< or a covariance that is none
  kClockJump = 4,  ///< so far ahead that its clock is doubted; believed once others follow
  kFlood = 5,      ///< more samples than the window holds
  kFailed = 6,     ///< an error inside or after finish(): see last_error()
};

struct Pose {
  double time_s;
  double x_m, y_m, z_m;
  double roll_rad, pitch_rad, yaw_rad;
  double covariance[36];
};

struct Landmark {
  double x_m, y_m, z_m;
  double covariance[9];
  std::int32_t times_seen;
  std::int32_t submaps;  ///< that saw it
};

enum class Health : std::int32_t { kWaiting = 0, kGood = 1, kDegraded = 2, kLost = 3 };
enum class Sensor : std::int32_t {
  kAttitude = 0,
  kCompass = 1,
  kDepth = 2,
  kAltitude = 3,
  kVelocity = 4,
  kSighting = 5,
  kFix = 6,
  kGyro = 7
};
enum class SensorState : std::int32_t {
  kUnheard = 0,
  kGood = 1,
  kSilent = 2,     ///< spoke once; a velocity log without the bottom is silent
  kRefused = 3,    ///< speaks, and is not believed
  kStuck = 4,      ///< says the very same again and again
  kWrongUnit = 5,  ///< would be right in another unit
};
inline constexpr std::size_t kSensors = 8;
inline constexpr std::size_t kAdviceLength = 128;
inline constexpr std::size_t kArrivals = 7;

struct Status {
  Health health;
  double position_sigma_m;           ///< larger semi-axis of the horizontal error
  std::int64_t arrivals[kArrivals];  ///< samples by Arrival
  double silent_for_s[kSensors];     ///< since the sensor was last used; negative: never heard
  std::int64_t used[kSensors], refused[kSensors];
  std::int32_t submaps, landmarks, loop_closures, compass_jumps;
  std::int32_t relocations;  ///< times that fixes showed the estimate to be wrong, or an operator set it
  SensorState sensors[kSensors];
  char advice[kAdviceLength];     ///< what to do about the worst of it; empty when all is well
  std::int32_t clock_changes;     ///< times that the clock of the samples was found set
  double clock_offset_s;          ///< of the time of the poses beyond that of the samples, since
  std::int32_t waits;             ///< times that feed() had to wait for the thread in the background
  bool joining;                   ///< that thread is at work
  std::int32_t closures_refused;  ///< of its own pairing and from elsewhere; the log says why
};

/// What an operator wants to know, as it happens.
enum class Note : std::int32_t { kSensor = 0, kClock = 1, kArrival = 2, kFix = 3, kRelocation = 4, kClosure = 5, kFailure = 6 };
using LogCallback = void (*)(void* context, Note note, double time_s, const char* text);

/// A setting by its key, as `ssjs-cli config dump --of underwater` lists them, and its value as text.
struct Setting {
  const char* key;
  const char* value;
};

class SSJS_ONLINE_API Estimator {
 public:
  /// Throws std::invalid_argument naming the setting that is unknown or out of its range.
  explicit Estimator(const Setting* settings = nullptr, std::size_t count = 0);
  ~Estimator();
  Estimator(const Estimator&) = delete;
  Estimator& operator=(const Estimator&) = delete;
  Estimator(Estimator&&) noexcept;
  Estimator& operator=(Estimator&&) noexcept;

  Arrival feed(const Gyro& sample) noexcept;
  Arrival feed(const Attitude& sample) noexcept;
  Arrival feed(const Compass& sample) noexcept;
  Arrival feed(const Depth& sample) noexcept;
  Arrival feed(const Altitude& sample) noexcept;
  Arrival feed(const Velocity& sample) noexcept;
  Arrival feed(const Sighting& sample) noexcept;
  Arrival feed(const Fix& sample) noexcept;
  /// Takes part when the submap of its later moment is joined.
  Arrival feed(const LoopClosure& closure) noexcept;

  /// At the time of the newest sample. False before the first one has gone through the filter.
  [[nodiscard]] bool pose(Pose* out) const noexcept;
  [[nodiscard]] Status status() const noexcept;

  /// Called within feed() and finish(), by their thread; must not throw nor call the estimator. Null: nothing is said.
  void set_log(LogCallback callback, void* context) noexcept;

  /// Everything through the filter, everything joined: the end of the mission. False on an error.
  bool finish() noexcept;

  /// The joined landmarks, at most `capacity`; returns how many there are. Waits for the background.
  std::size_t landmarks(Landmark* out, std::size_t capacity) noexcept;
  /// The corrected way, as landmarks().
  std::size_t trajectory(Pose* out, std::size_t capacity) noexcept;

  /// The whole state, into a file that appears whole or not at all: taken now, written by a thread. False: the file before is still being
  /// written, or could not be (see last_error()); nothing is done then.
  bool checkpoint(const char* path) noexcept;
  /// Waits for that file. False: it could not be written.
  bool wait_for_checkpoint() noexcept;
  /// The same as bytes, written to `out` when `capacity` suffices; returns how many they are, 0 on an error.
  std::size_t checkpoint(void* out, std::size_t capacity) noexcept;
  /// Becomes the estimator that was checkpointed, of the same settings. False: stays as it was, and last_error() says what is wrong with
  /// the file or which setting differs.
  bool restore(const char* path) noexcept;
  bool restore(const void* bytes, std::size_t size) noexcept;

  /// Text of the last kFailed or false; empty when there was none. Valid until the next call.
  [[nodiscard]] const char* last_error() const noexcept;

 private:
  class Inside;
  bool become(Inside* found) noexcept;
  Inside* inside_;
};

/// Version of the library that runs, "1.2.3".
SSJS_ONLINE_API const char* version() noexcept;

}  // namespace v1
}  // namespace ssjs::online
