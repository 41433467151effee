#include "ssjs/joining/map_placement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "joining/gaussian_world.hpp"
#include "ssjs/association/compatibility.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::random_map;

TEST(MapPlacement, L1_CovariancesAreThoseOfTheDisplacement) {
  // The displacement of every pair as a function of both states, propagated with numerical Jacobians: once with b placed by a pose of a,
  // once by an independent estimate.
  Rng rng(521);
  for (const bool inside : {true, false}) {
    LiveMap a = random_map(rng, 0, {7, 4}, 2, 5, 0.3);
    LiveMap b = random_map(rng, 7, {9}, 1, 4, 0.3);
    const MapPlacement placement =
        inside ? placement_inside(a, 7)
               : MapPlacement{{testing::random_pose(rng, 1), testing::correlated_covariance(rng, Eigen::Vector3d(0.5, 0.5, 0.05))}, {}};
    for (Eigen::Index i = 0; i < 4; ++i) {  // half a metre beside a landmark of a
      b.mean(b.landmark(i)) = placement.a_T_b.mean.inverse() * Eigen::Vector2d(a.mean(a.landmark(i)) + Eigen::Vector2d(0.3, -0.4));
    }
    const Eigen::Index n_a = a.mean.size();
    const Eigen::Index n_b = b.mean.size();
    Eigen::VectorXd x(n_a + n_b + 3);
    x << a.mean, b.mean, placement.a_T_b.mean.vector();
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(x.size(), x.size());
    P.topLeftCorner(n_a, n_a) = a.covariance;
    P.block(n_a, n_a, n_b, n_b) = b.covariance;
    P.bottomRightCorner<3, 3>() = placement.a_T_b.covariance;
    if (inside) {
      P.topRightCorner(n_a, 3) = a.covariance.leftCols<3>();
      P.bottomLeftCorner(3, n_a) = a.covariance.topRows<3>();
    }
    const MapMeeting meeting = meet(a, b, placement);
    ASSERT_GE(meeting.a_landmarks.size(), 4U);
    ASSERT_EQ(meeting.b_landmarks.size(), 4U);
    for (std::size_t i = 0; i < meeting.b_landmarks.size(); ++i) {
      for (std::size_t j = 0; j < meeting.a_landmarks.size(); ++j) {
        const Pair rows{static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)};
        const Pair pair = landmark_pairs(meeting, {rows}).front();
        const auto displacement = [&](const Eigen::VectorXd& state) -> Eigen::VectorXd {
          const Eigen::Vector2d b_p = state.segment<2>(n_a + b.landmark_offset(pair.observation));
          return Se2::from_vector(state.tail<3>()) * b_p - Eigen::Vector2d(state.segment<2>(a.landmark_offset(pair.prediction)));
        };
        EXPECT_LE((pair_residual(meeting.problem, rows.observation, rows.prediction) - displacement(x)).norm(), 1e-12);
        const Eigen::MatrixXd J = testing::numeric_jacobian(displacement, x);
        const Eigen::Matrix2d expected = J * P * J.transpose();
        EXPECT_LE((pair_covariance(meeting.problem, rows, rows) - expected).norm(), 1e-6 * expected.norm());
        // What the placement leaves open: the same without the landmark of b, and without that of a where they are independent.
        Eigen::MatrixXd P_open = P;
        P_open.block(n_a, n_a, n_b, n_b).setZero();
        if (!inside) P_open.topLeftCorner(n_a, n_a).setZero();
        const Eigen::Matrix2d open = J * P_open * J.transpose();
        EXPECT_NEAR(displacement_sigma(a, b, placement, pair), std::sqrt(open.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff()),
                    1e-6);
      }
    }
  }
}

TEST(MapPlacement, OnlyLandmarksThatCanMeetAreLookedAt) {
  Rng rng(522);
  LiveMap a = random_map(rng, 0, {3}, 1, 3, 0.01);
  LiveMap b = random_map(rng, 3, {4}, 1, 3, 0.01);
  a.mean << 10.0, 0.0, 0.0, /**/ 10.0, 5.0, /**/ 0.0, 0.0, /**/ 14.0, 5.0;
  b.mean << 5.0, 0.0, 0.0, /**/ 0.1, 5.2, /**/ 4.0, -5.0, /**/ 30.0, 0.0;
  const MapMeeting meeting = meet(a, b, placement_inside(a, 3));
  EXPECT_EQ(meeting.a_landmarks, std::vector<Eigen::Index>{0});
  EXPECT_EQ(meeting.b_landmarks, std::vector<Eigen::Index>{0});
  EXPECT_THROW((void)placement_inside(a, 5), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
