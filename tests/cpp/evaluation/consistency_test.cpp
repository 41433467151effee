#include "ssjs/evaluation/consistency.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "ssjs/base/error.hpp"
#include "ssjs/base/random.hpp"

namespace ssjs {
namespace {

TEST(Consistency, E8_NormalisedErrorByHand) {
  // P = [[2, 1], [1, 2]], P^-1 = [[2, -1], [-1, 2]] / 3, e = (1, 2): e' P^-1 e = (2 - 4 + 8) / 3 = 2
  Eigen::Matrix2d P;
  P << 2.0, 1.0, 1.0, 2.0;
  EXPECT_NEAR(normalized_squared_error(Eigen::Vector2d(1.0, 2.0), P), 2.0, 1e-14);
}

TEST(Consistency, E8_RefusesWhatIsNotACovariance) {
  Eigen::Matrix2d P;
  P << 1.0, 2.0, 2.0, 1.0;
  EXPECT_THROW((void)normalized_squared_error(Eigen::Vector2d(1.0, 2.0), P), NotPositiveDefinite);
  EXPECT_THROW((void)normalized_squared_error(Eigen::Vector3d(1.0, 2.0, 3.0), P), InvalidArgument);
}

TEST(Consistency, E9_BandsFromTheTable) {
  // chi-squared quantiles of standard tables: 0.025 and 0.975 at 3 degrees 0.2158, 9.348; at 100 degrees 74.222, 129.561
  const Band single = mean_band(3.0, 1);
  EXPECT_NEAR(single.lower, 0.2158, 5e-5);
  EXPECT_NEAR(single.upper, 9.348, 5e-4);
  const Band mean = mean_band(2.0, 50);
  EXPECT_NEAR(mean.lower, 74.222 / 50.0, 5e-4 / 50.0);
  EXPECT_NEAR(mean.upper, 129.561 / 50.0, 5e-4 / 50.0);
  // 0.05 and 0.95 at 10 degrees: 3.940, 18.307
  const Band ninety = mean_band(10.0, 1, 0.9);
  EXPECT_NEAR(ninety.lower, 3.940, 5e-4);
  EXPECT_NEAR(ninety.upper, 18.307, 5e-4);
}

TEST(Consistency, E9_SummaryByHand) {
  // bands: 1 degree [0.00098, 5.02], 3 degrees [0.216, 9.35]
  const ConsistencySummary summary = summarize({1.0, 6.0, 3.0, 0.1}, {1, 1, 3, 3});
  EXPECT_EQ(summary.samples, 4);
  EXPECT_NEAR(summary.mean, 10.1 / 4.0, 1e-14);
  EXPECT_NEAR(summary.mean_per_dof, 10.1 / 8.0, 1e-14);
  EXPECT_DOUBLE_EQ(summary.inside_fraction, 0.5);
  EXPECT_DOUBLE_EQ(summary.above_fraction, 0.25);
}

TEST(Consistency, E9_GaussianErrorsLieInside) {
  Rng rng(91);
  std::vector<double> values;
  const int samples = 4000;
  Eigen::Matrix2d P;
  P << 0.09, 0.06, 0.06, 0.08;  // L = [[0.3, 0], [0.2, 0.2]]
  for (int i = 0; i < samples; ++i) {
    const double first = rng.normal();
    const double second = rng.normal();
    values.push_back(normalized_squared_error(Eigen::Vector2d(0.3 * first, 0.2 * first + 0.2 * second), P));
  }
  const ConsistencySummary summary = summarize(values, std::vector<int>(samples, 2));
  const Band band = mean_band(2.0, samples, 0.999);
  EXPECT_GT(summary.mean, band.lower);
  EXPECT_LT(summary.mean, band.upper);
  EXPECT_NEAR(summary.inside_fraction, 0.95, 0.015);  // binomial deviation 0.0034
  EXPECT_NEAR(summary.above_fraction, 0.025, 0.01);
}

TEST(Consistency, EmptyInputGivesZeroSamples) {
  const ConsistencySummary summary = summarize({}, {});
  EXPECT_EQ(summary.samples, 0);
  EXPECT_EQ(summary.mean, 0.0);
}

TEST(Consistency, BrokenContractsAreNamed) {
  EXPECT_THROW((void)mean_band(0.0, 1), InvalidArgument);
  EXPECT_THROW((void)mean_band(2.0, 0), InvalidArgument);
  EXPECT_THROW((void)mean_band(2.0, 1, 1.0), InvalidArgument);
  EXPECT_THROW((void)summarize({1.0}, {}), InvalidArgument);
  EXPECT_THROW((void)summarize({1.0}, {0}), InvalidArgument);
  EXPECT_THROW((void)summarize({std::numeric_limits<double>::quiet_NaN()}, {2}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
