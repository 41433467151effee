// A vehicle loop: sensors of different rates feed an ssjs::online::Estimator, a pilot reads pose and health. It needs the installed header
// and library alone. The sensors here are made up on the spot: a vehicle on a square at 1.5 m/s, twelve objects on the seabed, white noise.
//   g++ -std=c++17 online_vehicle.cpp $(pkg-config --cflags --libs ssjs-online)
// With the name of a file it leaves its state there every minute, and goes on from it when it is started again.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "ssjs/embed/online.hpp"

namespace {

using namespace ssjs::online;

constexpr double kPi = 3.14159265358979323846;
constexpr double kSpeed = 1.5, kSide = 90.0, kTurnRate = 0.12, kStep = 0.1;  // m/s, m, rad/s, s
constexpr double kSeabed = 16.0, kDepth = 12.0, kSwath = 25.0;               // m

struct Object {
  double x, y;
};

/// Straight for a side, then a quarter turn, and again.
class Vehicle {
 public:
  double x = 0.0, y = 0.0, yaw = 0.0, rate = 0.0;
  void drive() {
    const double straight = kSide / kSpeed, turn = 0.5 * kPi / kTurnRate;
    rate = std::fmod(time_, straight + turn) < straight ? 0.0 : kTurnRate;
    x += kSpeed * kStep * std::cos(yaw);
    y += kSpeed * kStep * std::sin(yaw);
    yaw = std::remainder(yaw + rate * kStep, 2.0 * kPi);
    time_ += kStep;
  }

 private:
  double time_ = 0.0;
};

}  // namespace

int main(int count, char** arguments) {
  const Setting settings[] = {{"split.longest_m", "120"}, {"arrival.window_s", "0.5"}};
  Estimator estimator(settings, std::size(settings));
  const char* const state = count > 1 ? arguments[1] : nullptr;
  Pose last{};
  if (state != nullptr && (!estimator.restore(state) || !estimator.pose(&last))) std::printf("%s: begins anew\n", estimator.last_error());

  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) { return sigma * normal(random); };
  std::vector<Object> objects;
  for (int i = 0; i < 12; ++i) objects.push_back({15.0 + 6.0 * i, i % 2 == 0 ? 12.0 : -14.0});

  Vehicle vehicle;
  double worst_m = 0.0;
  const int steps = 6000;  // ten minutes, two and a half rounds
  for (int i = 0; i < steps; ++i) {
    const double t = i * kStep;
    if (i > 0 && t <= last.time_s) {  // before the start of this process
      vehicle.drive();
      continue;
    }
    estimator.feed(Gyro{t, {noise(0.0035), noise(0.0035), vehicle.rate + noise(0.0035)}});
    estimator.feed(Attitude{t, noise(0.009), noise(0.009)});
    estimator.feed(Compass{t, vehicle.yaw + 0.2 + noise(0.0175)});  // the offset of 0.2 rad is found
    estimator.feed(Depth{t, kDepth + noise(0.05)});
    if (i % 2 == 0) {
      estimator.feed(Velocity{t, {kSpeed + noise(0.015), noise(0.015), noise(0.015)}, true});
      estimator.feed(Altitude{t, kSeabed - kDepth + noise(0.1)});
    }
    if (vehicle.rate == 0.0) {
      for (const Object& object : objects) {
        const double dx = object.x - vehicle.x, dy = object.y - vehicle.y;
        const double ahead = std::cos(vehicle.yaw) * dx + std::sin(vehicle.yaw) * dy;
        const double across = -std::sin(vehicle.yaw) * dx + std::cos(vehicle.yaw) * dy;
        if (std::abs(ahead) > 0.5 * kSpeed * kStep || std::abs(across) > kSwath) continue;  // abeam, in the swath
        estimator.feed(Sighting{t, {ahead + noise(0.3), across + noise(0.2), kSeabed - kDepth + noise(0.3)}, false, {}, -1});
      }
    }

    Pose pose;
    if (estimator.pose(&pose)) {
      worst_m = std::max(worst_m, std::hypot(pose.x_m - vehicle.x, pose.y_m - vehicle.y));
      if (i % 600 == 0) {
        const Status status = estimator.status();
        std::printf("%4.0f s  x %7.2f  y %7.2f  +- %.2f m  %s  %d submaps, %d loops\n", pose.time_s, pose.x_m, pose.y_m,
                    status.position_sigma_m, status.health == Health::kGood ? "good" : "look at it", status.submaps, status.loop_closures);
      }
    }
    if (state != nullptr && i % 600 == 599 && !estimator.checkpoint(state)) std::printf("%s\n", estimator.last_error());
    vehicle.drive();
  }
  if (!estimator.finish()) {
    std::fprintf(stderr, "%s\n", estimator.last_error());
    return 1;
  }
  const Status status = estimator.status();
  std::printf("ssjs %s: %zu landmarks, %d loops, never more than %.2f m off\n", version(), estimator.landmarks(nullptr, 0),
              status.loop_closures, worst_m);
  return status.loop_closures > 0 && worst_m < 5.0 ? 0 : 1;
}
