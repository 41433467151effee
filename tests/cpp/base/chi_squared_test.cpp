#include "ssjs/base/chi_squared.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

/// P(X <= x) by arithmetic: from dof = 1 (erf) or dof = 2 (exponential) upwards with
/// Q(dof + 2) = Q(dof) + (x/2)^(dof/2) e^(-x/2) / Gamma(dof/2 + 1). Abramowitz and Stegun 26.4.4, 26.4.5, 26.4.8.
double cdf_by_recurrence(double x, int dof) {
  const bool odd = dof % 2 == 1;
  double upper = odd ? std::erfc(std::sqrt(0.5 * x)) : std::exp(-0.5 * x);
  double term = odd ? std::sqrt(2.0 * x / kPi) * std::exp(-0.5 * x) : 0.5 * x * std::exp(-0.5 * x);
  for (int k = odd ? 1 : 2; k < dof; k += 2) {
    upper += term;
    term *= x / (k + 2.0);
  }
  return 1.0 - upper;
}

TEST(ChiSquaredCdf, EqualsTheClosedFormsOfWholeDegrees) {
  constexpr double kTolerance = 1e-14;
  for (const int dof : {1, 2, 3, 4, 5, 9, 10, 29, 30, 31, 60, 151}) {
    for (const double factor : {0.05, 0.3, 0.8, 0.99, 1.0, 1.01, 1.3, 2.0, 5.0}) {
      const double x = factor * dof;
      EXPECT_NEAR(chi_squared_cdf(x, dof), cdf_by_recurrence(x, dof), kTolerance) << "dof " << dof << ", x " << x;
    }
  }
}

TEST(ChiSquaredCdf, EdgesOfItsDomain) {
  EXPECT_EQ(chi_squared_cdf(-1.0, 3.0), 0.0);
  EXPECT_EQ(chi_squared_cdf(0.0, 3.0), 0.0);
  EXPECT_EQ(chi_squared_cdf(std::numeric_limits<double>::infinity(), 3.0), 1.0);
  EXPECT_EQ(chi_squared_cdf(1e6, 3.0), 1.0);
  EXPECT_THROW((void)chi_squared_cdf(1.0, 0.0), InvalidArgument);
  EXPECT_THROW((void)chi_squared_cdf(1.0, std::nan("")), InvalidArgument);
  EXPECT_THROW((void)chi_squared_cdf(std::nan(""), 1.0), InvalidArgument);
}

TEST(ChiSquaredQuantile, TwoDegreesAreAnExponential) {
  constexpr double kRelativeTolerance = 1e-12;
  for (const double p : {1e-12, 1e-6, 0.01, 0.3, 0.49, 0.51, 0.9, 0.99, 0.999999}) {
    const double expected = -2.0 * std::log1p(-p);
    EXPECT_NEAR(chi_squared_quantile(p, 2.0), expected, kRelativeTolerance * expected) << p;
  }
}

TEST(ChiSquaredQuantile, OneDegreeIsTheSquareOfANormalQuantile) {
  // Normal quantiles at 0.975 and 0.995 to 16 digits (Abramowitz and Stegun table 26.6 gives them to 5).
  EXPECT_NEAR(chi_squared_quantile(0.95, 1.0), 1.959963984540054 * 1.959963984540054, 4e-12);
  EXPECT_NEAR(chi_squared_quantile(0.99, 1.0), 2.575829303548901 * 2.575829303548901, 7e-12);
}

TEST(ChiSquaredQuantile, EqualsThePublishedTable) {
  // NIST/SEMATECH e-Handbook of Statistical Methods, section 1.3.6.7.4, critical values of the chi-square distribution.
  struct Row {
    double dof, at_0_025, at_0_95, at_0_99;
  };
  const std::vector<Row> table = {{1, 0.001, 3.841, 6.635},     {2, 0.051, 5.991, 9.210},       {3, 0.216, 7.815, 11.345},
                                  {5, 0.831, 11.070, 15.086},   {10, 3.247, 18.307, 23.209},    {30, 16.791, 43.773, 50.892},
                                  {50, 32.357, 67.505, 76.154}, {100, 74.222, 124.342, 135.807}};
  constexpr double kHalfDigit = 5.0001e-4;  // the table has three decimals
  for (const Row& row : table) {
    EXPECT_NEAR(chi_squared_quantile(0.025, row.dof), row.at_0_025, kHalfDigit) << row.dof;
    EXPECT_NEAR(chi_squared_quantile(0.95, row.dof), row.at_0_95, kHalfDigit) << row.dof;
    EXPECT_NEAR(chi_squared_quantile(0.99, row.dof), row.at_0_99, kHalfDigit) << row.dof;
  }
}

TEST(ChiSquaredQuantile, InvertsTheCdf) {
  constexpr double kTolerance = 1e-11;  // a rounding unit of log x moves the probability by sqrt(dof / pi) units
  for (const double dof : {0.2, 1.0, 2.5, 7.0, 29.9, 30.1, 400.0, 3e4, 1e6}) {
    for (const double p : {1e-9, 0.025, 0.4999, 0.5, 0.5001, 0.975, 0.9999}) {
      EXPECT_NEAR(chi_squared_cdf(chi_squared_quantile(p, dof), dof), p, kTolerance) << "dof " << dof << ", p " << p;
    }
  }
}

TEST(ChiSquaredQuantile, ManyDegreesApproachTheNormalExpansion) {
  // Cornish-Fisher: x = k + z sqrt(2k) + 2/3 (z^2 - 1) + (z^3 - 7z) / (9 sqrt(2k)) + O(1/k); z = 1.959963984540054
  const double k = 1e6;
  const double z = 1.959963984540054;
  const double expected = k + z * std::sqrt(2.0 * k) + 2.0 / 3.0 * (z * z - 1.0) + (z * z * z - 7.0 * z) / (9.0 * std::sqrt(2.0 * k));
  EXPECT_NEAR(chi_squared_quantile(0.975, k), expected, 1e-5);  // the next term is of the order 1 / k
}

TEST(ChiSquaredQuantile, RefusesWhatHasNoAnswer) {
  for (const double p : {0.0, 1.0, -0.1, 1.1, std::nan("")}) EXPECT_THROW((void)chi_squared_quantile(p, 2.0), InvalidArgument) << p;
  EXPECT_THROW((void)chi_squared_quantile(0.5, 0.0), InvalidArgument);
  EXPECT_THROW((void)chi_squared_quantile(0.5, -2.0), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
