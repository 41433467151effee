// The filter with a frozen pose, beside full matrices over [vehicle | frozen pose | landmarks].
#include <gtest/gtest.h>

#include "filter/dense_filter.hpp"
#include "geometry/numeric_jacobian.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/filter/ekf.hpp"

namespace ssjs {
namespace {

using testing::kJacobianPoints;
using testing::largest_difference;
using testing::numeric_jacobian;
using testing::random_covariance;
using testing::random_matrix;
using testing::random_motion;
using testing::random_observation;
using testing::random_pose;

constexpr double kRounding = 1e-11;
constexpr StateLayout kLayout{true};

TEST(FrozenPose, F9_F10_EqualsTheDenseFilter) {
  Rng rng(801);
  Ekf filter(2, ErrorForm::kAdditive, kLayout);
  const GaussianSe2 start{{1.0, -2.0, 0.5}, random_covariance(rng, 3, 0.4)};
  filter.reset(start);
  Eigen::VectorXd mean = start.mean.vector().replicate<2, 1>();
  Eigen::MatrixXd P = start.covariance.replicate<2, 2>();
  const auto append = [&](const Eigen::MatrixXd& J, const Eigen::Vector2d& place, const Eigen::Matrix2d& noise) {
    const Eigen::Index n = mean.size();
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n + 2, n);
    G.topRows(n).setIdentity();
    G.bottomRows(2) = J;
    P = (G * P * G.transpose()).eval();
    P.bottomRightCorner<2, 2>() += noise;
    mean.conservativeResize(n + 2);
    mean.tail<2>() = place;
  };
  for (int step = 0; step < 60; ++step) {
    const MotionPrediction motion = random_motion(rng, filter.vehicle_pose());
    filter.predict(motion);
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(P.rows(), P.cols());
    F.topLeftCorner<3, 3>() = motion.F;
    P = (F * P * F.transpose()).eval();
    P.topLeftCorner<3, 3>() += motion.Q;
    mean.head<3>() = motion.submap_T_vehicle.vector();

    const Eigen::Vector2d place = random_matrix(rng, 2, 1, 3.0);
    const Eigen::Matrix2d noise = random_covariance(rng, 2, 0.3);
    if (step % 5 == 0) {
      const Eigen::Matrix<double, 2, 3> J_vehicle = random_matrix(rng, 2, 3);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, P.cols());
      J.leftCols<3>() = J_vehicle;
      filter.add_landmark(place, J_vehicle, noise);
      append(J, place, noise);
    } else if (step % 7 == 0) {
      const Eigen::Matrix<double, 2, Eigen::Dynamic> J = random_matrix(rng, 2, P.cols(), 0.3);
      filter.add_dependent_landmark(place, J, noise);
      append(J, place, noise);
    } else if (step % 11 == 0) {  // the last landmark takes the place of the first
      filter.remove_landmark(0);
      const Eigen::Index last = mean.size() - 2;
      Eigen::MatrixXd G = Eigen::MatrixXd::Identity(last, last + 2);
      G.block(6, 6, 2, last - 4).setZero();
      G.block<2, 2>(6, last).setIdentity();
      mean = (G * mean).eval();
      P = (G * P * G.transpose()).eval();
    }
    if (step % 2 == 0) {
      const std::vector<LinearObservation> observations{random_observation(rng, 0), random_observation(rng, filter.landmarks() - 1)};
      const auto k = static_cast<Eigen::Index>(filter.landmarks() > 1 ? 4 : 2);
      Eigen::MatrixXd H = Eigen::MatrixXd::Zero(k, P.cols());
      Eigen::MatrixXd R = Eigen::MatrixXd::Zero(k, k);
      Eigen::VectorXd residual(k);
      for (Eigen::Index i = 0; i < k; i += 2) {
        const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
        H.block<2, 3>(i, 0) = z.H_vehicle;
        H.block<2, 2>(i, kLayout.offset(z.landmark)) = z.H_landmark;
        R.block<2, 2>(i, i) = z.R;
        residual.segment<2>(i) = z.residual;
      }
      filter.update({observations.begin(), observations.begin() + k / 2});
      const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
      mean += K * residual;
      P = (P - K * H * P).eval();
      P = (0.5 * (P + P.transpose())).eval();
    }
    mean(2) = wrap_angle(mean(2));
    mean(5) = wrap_angle(mean(5));
    const MapState state = filter.state();
    ASSERT_EQ(state.landmarks(), filter.landmarks());
    ASSERT_LE(largest_difference(state.mean, mean), kRounding) << step;
    ASSERT_LE(largest_difference(state.covariance, P), kRounding) << step;
    ASSERT_EQ(filter.frozen_pose().vector(), state.mean.segment<3>(3));
  }
  EXPECT_GE(filter.landmarks(), 10);

  // a restored filter goes on as the first would have
  Ekf other(1, ErrorForm::kAdditive, kLayout);
  other.restore(filter.state());
  const MotionPrediction motion = random_motion(rng, filter.vehicle_pose());
  const LinearObservation z = random_observation(rng, 3);
  for (Ekf* const both : {&filter, &other}) {
    both->predict(motion);
    both->update({z});
  }
  EXPECT_LE(largest_difference(filter.state().covariance, other.state().covariance), kRounding);
  EXPECT_LE(largest_difference(filter.state().mean, other.state().mean), kRounding);
}

TEST(FrozenPose, F9_TheVehicleSeenFromIt) {
  Rng rng(802);
  for (int i = 0; i < kJacobianPoints; ++i) {
    const Se2 frozen = random_pose(rng, i);
    const Se2 vehicle = random_pose(rng, i + 7);
    Ekf filter(1, ErrorForm::kAdditive, kLayout);
    MapState state{Eigen::VectorXd(6), random_covariance(rng, 6, 0.3), kLayout};
    state.mean << vehicle.vector(), frozen.vector();
    filter.restore(state);
    const auto seen = [](const Eigen::Matrix<double, 6, 1>& x) -> Eigen::Vector3d {
      return (Se2::from_vector(x.tail<3>()).inverse() * Se2::from_vector(x.head<3>())).vector();
    };
    const Eigen::Matrix<double, 3, 6> J = numeric_jacobian(seen, Eigen::Matrix<double, 6, 1>(state.mean), {2});
    const GaussianSe2 answer = filter.frozen_T_vehicle();
    EXPECT_LE(additive_difference(answer.mean, Se2::from_vector(seen(state.mean))).norm(), 1e-12);
    const Eigen::Matrix3d expected = J * state.covariance * J.transpose();
    EXPECT_LE((answer.covariance - expected).cwiseAbs().maxCoeff(), 1e-4 * expected.trace());
  }
}

TEST(FrozenPose, RefusesWhatItCannotDo) {
  EXPECT_THROW(Ekf(4, ErrorForm::kInvariant, kLayout), InvalidArgument);
  Ekf plain(4);
  EXPECT_THROW(plain.restore({Eigen::VectorXd::Zero(6), Eigen::MatrixXd::Identity(6, 6), kLayout}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
