// Any stream of samples into the vehicle's estimator: bytes become calls. It never crashes, hangs or throws, keeps count of every sample,
// and what it says of the vehicle is a number. Submaps are small, so that a few dozen samples close some and the level above ties them.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "byte_stream.hpp"
#include "ssjs/embed/online.hpp"

namespace {

using namespace ssjs::online;
using ssjs::fuzz::ByteStream;

void check(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

/// Two bits each of the first byte choose among these.
constexpr std::array<const char*, 4> kLongest = {"3", "10", "40", "1000"};
constexpr std::array<const char*, 4> kWindow = {"0", "0.5", "3", "30"};
constexpr std::array<const char*, 4> kDelay = {"0", "1", "5", "1000"};
constexpr std::array<const char*, 4> kCompass = {"filter", "mean", "first_reading", "none"};

class Session {
 public:
  Session(ByteStream& bytes, Estimator& estimator) : bytes_(bytes), estimator_(estimator) {
    estimator.set_log([](void* notes, Note, double, const char* text) { *static_cast<std::size_t*>(notes) += std::strlen(text); }, &said_);
  }

  void play() {
    while (!bytes_.empty()) act();
    look();
    const bool finished = estimator_.finish();
    if (!finished) check(estimator_.last_error()[0] != '\0', "a failure says why");
    look();
    check(estimator_.feed(Depth{now_s_ + 1.0, 0.0}) != Arrival::kTaken || !finished, "nothing is taken after the end");
  }

 private:
  static constexpr int kKinds = 11, kClosure = kKinds;  ///< the last by bytes of its own: what older inputs mean stays

  void act() {
    const std::uint8_t what = bytes_.byte();
    odd_ = what >= 240;  // its values are anything
    now_s_ = time();
    ++fed_;
    Arrival arrival = Arrival::kTaken;
    switch (what == 119 || what >= 252 ? kClosure : what % kKinds) {
      case 0:
        arrival = estimator_.feed(Gyro{now_s_, {value(0.3), value(0.3), value(0.5)}});
        break;
      case 1:
        arrival = estimator_.feed(Attitude{now_s_, value(0.5), value(0.5)});
        break;
      case 2:
        arrival = estimator_.feed(Compass{now_s_, value(7.0)});
        break;
      case 3:
        arrival = estimator_.feed(Depth{now_s_, value(30.0)});
        break;
      case 4:
        arrival = estimator_.feed(Altitude{now_s_, value(20.0)});
        break;
      case 5:
      case 6:  // what moves a vehicle comes more often
        arrival = estimator_.feed(Velocity{now_s_, {value(4.0), value(0.5), value(0.5)}, bytes_.below(8) > 0});
        break;
      case 7:
      case 8:
        arrival = estimator_.feed(sighting());
        break;
      case 9:
        arrival = estimator_.feed(fix());
        break;
      case kClosure:
        arrival = estimator_.feed(closure());
        break;
      default:
        --fed_;
        if (bytes_.below(4) == 0) restart();
        look();
    }
    check(static_cast<std::size_t>(arrival) < kArrivals, "the arrival is one of those known");
  }

  /// Mostly a little later; sometimes again, earlier, far ahead or anything.
  double time() {
    const std::uint8_t step = bytes_.byte();
    if (step < 200) return now_s_ + 0.01 * step;
    if (step < 230) return now_s_ - 0.05 * (step - 200);
    if (step < 250) return now_s_ + 5.0 * (step - 229);
    if (step == 250) return now_s_ + 1e9;
    if (step == 251) return now_s_ - 1e9;
    return step < 254 ? now_s_ : bytes_.any();
  }

  double value(double scale) { return odd_ ? bytes_.any() : bytes_.plausible(scale); }

  Sighting sighting() {
    Sighting seen{now_s_, {value(5.0), value(25.0), value(20.0)}, false, {}, -1};
    const std::uint8_t kind = bytes_.byte();
    if (kind % 4 == 1) seen.landmark_id = kind / 4;
    if (kind % 4 == 2) {
      seen.has_covariance = true;
      for (const std::size_t i : {0U, 4U, 8U}) seen.covariance_m2[i] = 0.01 * (1 + kind / 4);
    }
    if (kind % 4 == 3) {
      seen.has_covariance = true;
      for (double& each : seen.covariance_m2) each = value(1.0);
    }
    return seen;
  }

  Fix fix() {
    Fix known{now_s_, value(50.0), value(50.0), {4.0, 0.0, 0.0, 4.0}, bytes_.below(4) == 0};
    if (odd_) {
      for (double& each : known.covariance_m2) each = value(1.0);
    }
    return known;
  }

  LoopClosure closure() {
    LoopClosure claimed{now_s_ - std::abs(value(60.0)), now_s_, value(30.0), value(30.0), value(4.0), {0.04, 0, 0, 0, 0.04, 0, 0, 0, 1e-4}};
    if (odd_) {
      for (double& each : claimed.covariance) each = value(1.0);
    }
    return claimed;
  }

  /// What was written down is taken up again, and is the same.
  void restart() {
    std::vector<char> state(estimator_.checkpoint(nullptr, 0));
    check(estimator_.checkpoint(state.data(), state.size()) == state.size(), "the state stays while nothing is fed");
    if (state.empty()) return;
    check(estimator_.restore(state.data(), state.size()), "a state that was written is read");
    std::vector<char> again(state.size());
    check(estimator_.checkpoint(again.data(), again.size()) == state.size() && again == state, "the state read is the one written");
  }

  void look() {
    Pose pose{};
    if (estimator_.pose(&pose)) {
      for (const double each : {pose.x_m, pose.y_m, pose.z_m, pose.roll_rad, pose.pitch_rad, pose.yaw_rad})
        check(std::isfinite(each), "the pose is finite");
      for (int i = 0; i < 6; ++i) check(pose.covariance[7 * i] >= 0.0, "variances are numbers, not negative");
    }
    const Status status = estimator_.status();
    std::int64_t arrivals = 0;
    for (const std::int64_t each : status.arrivals) arrivals += each;
    check(std::memchr(status.advice, 0, kAdviceLength) != nullptr, "the advice ends");
    check(arrivals == fed_, "every sample is counted once");
    std::vector<Landmark> landmarks(estimator_.landmarks(nullptr, 0));
    check(estimator_.landmarks(landmarks.data(), landmarks.size()) == landmarks.size(), "landmarks stay while nothing is fed");
    std::vector<Pose> trajectory(estimator_.trajectory(nullptr, 0));
    check(estimator_.trajectory(trajectory.data(), trajectory.size()) == trajectory.size(), "the trajectory stays while nothing is fed");
  }

  ByteStream& bytes_;
  Estimator& estimator_;
  double now_s_ = 0.0;
  std::int64_t fed_ = 0;
  std::size_t said_ = 0;
  bool odd_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteStream bytes(data, size);
  const std::uint8_t choice = bytes.byte();
  const std::array<Setting, 6> settings = {{{"split.longest_m", kLongest[choice & 3U]},
                                            {"split.max_landmarks", "6"},
                                            {"arrival.window_s", kWindow[(choice >> 2U) & 3U]},
                                            {"joining_delay_s", kDelay[(choice >> 4U) & 3U]},
                                            {"compass_use", kCompass[(choice >> 6U) & 3U]},
                                            {"split.needs_velocity_fix", bytes.below(4) == 0 ? "false" : "true"}}};
  Estimator estimator(settings.data(), settings.size());
  Session(bytes, estimator).play();
  return 0;
}
