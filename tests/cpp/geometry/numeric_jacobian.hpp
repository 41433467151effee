/// Central differences: the oracle of every analytic Jacobian.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <initializer_list>
#include <string>

#include "ssjs/base/angle.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/geometry/se2.hpp"

namespace ssjs::testing {

/// |analytic - numeric| allowed for every entry. The truncation error is h^2 f'''/6 (about 1e-10 for values near 100), the rounding error
/// eps f / h (about 1e-8).
inline constexpr double kJacobianTolerance = 1e-6;
inline constexpr double kDifferenceStep = 1e-6;
inline constexpr int kJacobianPoints = 50;

/// df/dx by central differences. f takes and returns fixed-size vectors; differences in `angle_rows` of f are wrapped.
template <class Function, int Inputs>
auto numeric_jacobian(const Function& f, const Eigen::Matrix<double, Inputs, 1>& x, std::initializer_list<Eigen::Index> angle_rows = {}) {
  using Output = decltype(f(x));
  Eigen::Matrix<double, Output::RowsAtCompileTime, Inputs> J(f(x).rows(), x.rows());
  for (Eigen::Index column = 0; column < x.rows(); ++column) {
    Eigen::Matrix<double, Inputs, 1> forward = x;
    Eigen::Matrix<double, Inputs, 1> backward = x;
    forward(column) += kDifferenceStep;
    backward(column) -= kDifferenceStep;
    Output difference = f(forward) - f(backward);
    for (const Eigen::Index row : angle_rows) difference(row) = wrap_angle(difference(row));
    J.col(column) = difference / (forward(column) - backward(column));
  }
  return J;
}

/// Passes when every entry agrees; NaN anywhere fails.
template <class Analytic, class Numeric>
::testing::AssertionResult jacobians_agree(const Analytic& analytic, const Numeric& numeric) {
  if (analytic.rows() != numeric.rows() || analytic.cols() != numeric.cols()) return ::testing::AssertionFailure() << "sizes differ";
  for (Eigen::Index row = 0; row < analytic.rows(); ++row) {
    for (Eigen::Index column = 0; column < analytic.cols(); ++column) {
      const double error = std::abs(analytic(row, column) - numeric(row, column));
      if (!(error < kJacobianTolerance)) {
        return ::testing::AssertionFailure() << "entry (" << row << ", " << column << "): analytic " << analytic(row, column)
                                             << ", numeric " << numeric(row, column);
      }
    }
  }
  return ::testing::AssertionSuccess();
}

/// A pose within 50 m; every other one heads within 1e-4 rad of +-pi, where wrapping goes wrong first.
inline Se2 random_pose(Rng& rng, int point) {
  const double side = point % 4 < 2 ? kPi : -kPi;
  const double heading = point % 2 == 0 ? rng.uniform(-kPi, kPi) : side + rng.uniform(-1e-4, 1e-4);
  return Se2::from_vector({rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0), heading});
}

}  // namespace ssjs::testing
