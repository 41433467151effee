#include "ssjs/geometry/measurement_noise.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace ssjs {
namespace {

Eigen::Matrix2d noise(double xx, double xy, double yx, double yy) { return (Eigen::Matrix2d() << xx, xy, yx, yy).finished(); }

TEST(MeasurementNoise, IsSymmetricAndPositiveDefinite) {
  EXPECT_TRUE(is_measurement_noise(noise(4.0, 0.0, 0.0, 1e-4)));
  EXPECT_TRUE(is_measurement_noise(noise(1.0, 0.99, 0.99 + 1e-12, 1.0)));
  EXPECT_FALSE(is_measurement_noise(noise(1.0, 0.1, 0.2, 1.0)));
  EXPECT_FALSE(is_measurement_noise(noise(1.0, 1.1, 1.1, 1.0)));
  EXPECT_FALSE(is_measurement_noise(noise(-1.0, 0.0, 0.0, 1.0)));
  EXPECT_FALSE(is_measurement_noise(noise(0.0, 0.0, 0.0, 0.0)));
}

TEST(MeasurementNoise, IsThatOfASensor) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double variance : {1e-320, 1e-300, 1e-20, 1e13, 1e300, kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(is_measurement_noise(noise(1.0, 0.0, 0.0, variance))) << variance;
    EXPECT_FALSE(is_measurement_noise(noise(variance, 0.0, 0.0, variance))) << variance;
  }
  EXPECT_FALSE(is_measurement_noise(noise(1e300, 1e300, 1e300, 1e300)));
  EXPECT_FALSE(is_measurement_noise(noise(1.0, 1.0 - 1e-19, 1.0 - 1e-19, 1.0)));  // each alone is one, together they say too much
  EXPECT_TRUE(is_measurement_noise(noise(1e12, 0.0, 0.0, 1.1e-18)));
}

}  // namespace
}  // namespace ssjs
