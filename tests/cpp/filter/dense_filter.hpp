/// A textbook Kalman filter over [vehicle | landmarks]: full matrices, no blocks, no factorisation. The oracle of the fast one.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

#include "ssjs/base/random.hpp"
#include "ssjs/filter/ekf.hpp"

namespace ssjs::testing {

/// Mean and covariance of [x y heading | x y | ...]; headings are not wrapped.
struct DenseFilter {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(3);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(3, 3);

  void predict(const MotionPrediction& motion) {
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(P.rows(), P.cols());
    F.topLeftCorner<3, 3>() = motion.F;
    mean.head<3>() = motion.submap_T_vehicle.vector();
    P = (F * P * F.transpose()).eval();
    P.topLeftCorner<3, 3>() += motion.Q;
  }
  void add(const Eigen::Vector2d& position, const Eigen::Matrix<double, 2, 3>& J_vehicle, const Eigen::Matrix2d& noise) {
    const Eigen::Index n = mean.size();
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n + 2, n);
    G.topRows(n).setIdentity();
    G.bottomLeftCorner<2, 3>() = J_vehicle;
    P = (G * P * G.transpose()).eval();
    P.bottomRightCorner<2, 2>() += noise;
    mean.conservativeResize(n + 2);
    mean.tail<2>() = position;
  }
  /// The last landmark takes the place of the removed one.
  void remove(Eigen::Index landmark) {
    const Eigen::Index last = mean.size() - 2;
    Eigen::MatrixXd G = Eigen::MatrixXd::Identity(last, last + 2);
    if (3 + 2 * landmark != last) {
      G.middleRows<2>(3 + 2 * landmark).setZero();
      G.block<2, 2>(3 + 2 * landmark, last).setIdentity();
    }
    mean = (G * mean).eval();
    P = (G * P * G.transpose()).eval();
  }
  /// Joseph form; returns the normalised innovation squared.
  double update(const std::vector<LinearObservation>& observations) {
    const auto k = static_cast<Eigen::Index>(2 * observations.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(k, mean.size());
    Eigen::MatrixXd R = Eigen::MatrixXd::Zero(k, k);
    Eigen::VectorXd residual(k);
    for (Eigen::Index i = 0; i < k; i += 2) {
      const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
      H.block<2, 3>(i, 0) = z.H_vehicle;
      H.block<2, 2>(i, 3 + 2 * z.landmark) = z.H_landmark;
      R.block<2, 2>(i, i) = z.R;
      residual.segment<2>(i) = z.residual;
    }
    const Eigen::MatrixXd S = H * P * H.transpose() + R;
    const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    mean += K * residual;
    P = (A * P * A.transpose() + K * R * K.transpose()).eval();
    return residual.dot(S.inverse() * residual);
  }

  /// The same in right-invariant coordinates: delta = M xi, with the update linear in xi and the state moved by its exponential.
  double update_invariantly(const std::vector<LinearObservation>& observations) {
    DenseFilter invariant{Eigen::VectorXd::Zero(mean.size()), M().inverse() * P * M().inverse().transpose()};
    std::vector<LinearObservation> in_xi = observations;
    for (LinearObservation& z : in_xi) {  // H M: every landmark turns with the heading
      const Eigen::Vector2d p = mean.segment<2>(3 + 2 * z.landmark);
      z.H_vehicle.col(2) += z.H_vehicle.leftCols<2>() * Eigen::Vector2d(-mean(1), mean(0)) + z.H_landmark * Eigen::Vector2d(-p.y(), p.x());
    }
    const double nis = invariant.update(in_xi);
    const Eigen::VectorXd& xi = invariant.mean;
    mean.head<3>() = (se2_exp(xi.head<3>()) * Se2::from_vector(mean.head<3>())).vector();
    for (Eigen::Index at = 3; at < mean.size(); at += 2) {
      mean.segment<2>(at) = se2_exp({xi(at), xi(at + 1), xi(2)}) * Eigen::Vector2d(mean.segment<2>(at));
    }
    P = M() * invariant.P * M().transpose();
    return nis;
  }

 private:
  [[nodiscard]] Eigen::MatrixXd M() const {
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(mean.size(), mean.size());
    M(0, 2) = -mean(1);
    M(1, 2) = mean(0);
    for (Eigen::Index at = 3; at < mean.size(); at += 2) M.block<2, 1>(at, 2) << -mean(at + 1), mean(at);
    return M;
  }
};

/// Largest entry of |a - b|; NaN stays NaN.
inline double largest_difference(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b) {
  return (a - b).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

inline ::testing::AssertionResult same_state(Ekf& filter, const DenseFilter& oracle, double tolerance) {
  const MapState state = filter.state();
  if (state.mean.size() != oracle.mean.size())
    return ::testing::AssertionFailure() << "sizes " << state.mean.size() << ", " << oracle.mean.size();
  const double mean = largest_difference(state.mean, oracle.mean);
  const double covariance = largest_difference(state.covariance, oracle.P);
  if (!(mean <= tolerance && covariance <= tolerance)) {
    return ::testing::AssertionFailure() << "means differ by " << mean << ", covariances by " << covariance;
  }
  return ::testing::AssertionSuccess();
}

/// rows x columns standard normal numbers times `scale`.
inline Eigen::MatrixXd random_matrix(Rng& rng, Eigen::Index rows, Eigen::Index columns, double scale = 1.0) {
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c) {
    for (Eigen::Index r = 0; r < rows; ++r) matrix(r, c) = rng.normal(scale);
  }
  return matrix;
}

/// A well-conditioned covariance with standard deviations of about `sigma`.
inline Eigen::MatrixXd random_covariance(Rng& rng, Eigen::Index n, double sigma) {
  const Eigen::MatrixXd A = random_matrix(rng, n, n);
  return sigma * sigma * (A * A.transpose() / static_cast<double>(n) + 0.2 * Eigen::MatrixXd::Identity(n, n));
}

inline MotionPrediction random_motion(Rng& rng, const Se2& pose) {
  MotionPrediction motion;
  motion.submap_T_vehicle = additive_step(pose, Eigen::Vector3d(rng.normal(0.5), rng.normal(0.5), rng.normal(0.1)));
  motion.F = Eigen::Matrix3d::Identity() + random_matrix(rng, 3, 3, 0.1);
  motion.Q = random_covariance(rng, 3, 0.1);
  return motion;
}

inline LinearObservation random_observation(Rng& rng, Eigen::Index landmark) {
  return {landmark, random_matrix(rng, 2, 1, 0.2), random_matrix(rng, 2, 3), random_matrix(rng, 2, 2), random_covariance(rng, 2, 0.3)};
}

}  // namespace ssjs::testing
