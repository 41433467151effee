#include "ssjs/pipeline/gyro_witness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/se3.hpp"

namespace ssjs {
namespace {

constexpr double kStep_s = 0.1;

/// A vehicle that rolls, pitches and turns, and what its sensors say of it: 0.2 degrees and 0.2 degrees a second of noise, 1 degree of the
/// compass, ten times a second.
class Turning {
 public:
  NavigationTick next() {
    const double t = kStep_s * static_cast<double>(count_++);
    const auto rpy_at = [](double s) { return Eigen::Vector3d(0.1 * std::sin(0.7 * s), 0.08 * std::cos(0.5 * s), 0.15 * s); };
    const Eigen::Vector3d rpy = rpy_at(t);
    const Eigen::Vector3d rates = (rpy_at(t + kStep_s) - rpy) / kStep_s;
    const auto noise = [&] { return Eigen::Vector3d(rng_.normal(), rng_.normal(), rng_.normal()); };
    NavigationTick tick = tick_at(t);
    tick.gyro_rad_s = euler_rate_matrix(rpy) * rates + 0.0035 * noise();
    const Eigen::Vector3d seen = rpy + 0.0035 * noise();
    tick.roll_pitch_rad = seen.head<2>();
    tick.compass_rad = wrap_angle(rpy.z() + 0.4 + 0.0175 * rng_.normal());
    return tick;
  }
  Rng& rng() { return rng_; }

 private:
  Rng rng_{7};
  int count_ = 0;
};

TEST(GyroWitness, ARightGyroIsBelievedForAnHour) {
  Turning vehicle;
  GyroWitness witness(0.1, 20);
  for (int i = 0; i < 36000; ++i) {
    witness.see(vehicle.next());
    ASSERT_FALSE(witness.is_doubted()) << 0.1 * i;
  }
}

TEST(GyroWitness, OutliersAreSeenWithinSecondsAndForgivenOnceTheyEnd) {
  Turning vehicle;
  GyroWitness witness(0.1, 20);
  for (int i = 0; i < 300; ++i) witness.see(vehicle.next());
  int until_doubt = 0;
  for (int i = 0; i < 600; ++i) {
    NavigationTick tick = vehicle.next();
    if (vehicle.rng().uniform() < 0.3) tick.gyro_rad_s->z() = vehicle.rng().uniform(-1.0, 1.0);
    if (vehicle.rng().uniform() < 0.3) tick.gyro_rad_s->x() = vehicle.rng().uniform(-1.0, 1.0);
    witness.see(tick);
    until_doubt += witness.is_doubted() ? 0 : 1;
    if (witness.astray_rad()) {
      EXPECT_GE(witness.astray_rad()->minCoeff(), 0.2);
    }
  }
  EXPECT_LT(until_doubt, 100);
  int until_believed = 0;
  for (int i = 0; i < 3000 && witness.is_doubted(); ++i, ++until_believed) witness.see(vehicle.next());
  EXPECT_FALSE(witness.is_doubted());
  EXPECT_GE(until_believed, 18 * 15);
}

TEST(GyroWitness, AnotherUnitIsSeen) {
  Turning vehicle;
  GyroWitness witness(0.1, 20);
  for (int i = 0; i < 100; ++i) {
    NavigationTick tick = vehicle.next();
    *tick.gyro_rad_s *= 180.0 / kPi;
    witness.see(tick);
  }
  EXPECT_TRUE(witness.is_doubted());
}

TEST(GyroWitness, BadAttitudesAndASilentGyroAreNotItsFault) {
  Turning vehicle;
  GyroWitness witness(0.1, 20);
  NavigationTick hangs;
  for (int i = 0; i < 6000; ++i) {
    NavigationTick tick = vehicle.next();
    if (vehicle.rng().uniform() < 0.3)
      *tick.roll_pitch_rad += Eigen::Vector2d(vehicle.rng().uniform(-0.5, 0.5), vehicle.rng().uniform(-0.5, 0.5));
    if (i > 1000 && i < 2000) tick.compass_rad = hangs.compass_rad;  // hangs while the vehicle turns twice
    if (i == 1000) hangs = tick;
    if (i > 3000 && i < 3400) tick.gyro_rad_s.reset();
    witness.see(tick);
    ASSERT_FALSE(witness.is_doubted()) << 0.1 * i;
  }
}

TEST(GyroWitness, NobodyLooksWhereNobodyIsAsked) {
  Turning vehicle;
  GyroWitness witness(std::nullopt, 20);
  for (int i = 0; i < 200; ++i) {
    NavigationTick tick = vehicle.next();
    *tick.gyro_rad_s *= 10.0;
    witness.see(tick);
    ASSERT_FALSE(witness.is_doubted());
  }
}

}  // namespace
}  // namespace ssjs
