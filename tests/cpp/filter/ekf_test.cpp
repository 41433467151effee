#include "ssjs/filter/ekf.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "filter/dense_filter.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

using testing::DenseFilter;
using testing::largest_difference;
using testing::random_covariance;
using testing::random_matrix;
using testing::random_motion;
using testing::random_observation;
using testing::same_state;

constexpr double kRounding = 1e-12;  // of numbers near 1

/// Both filters through the same operations.
struct Twin {
  explicit Twin(Eigen::Index capacity) : filter(capacity) {}

  void reset(const GaussianSe2& vehicle) {
    filter.reset(vehicle);
    oracle.mean = vehicle.mean.vector();
    oracle.P = vehicle.covariance;
  }
  void predict(const MotionPrediction& motion) {
    filter.predict(motion);
    oracle.predict(motion);
  }
  void add(const Eigen::Vector2d& position, const Eigen::Matrix<double, 2, 3>& J_vehicle, const Eigen::Matrix2d& noise) {
    filter.add_landmark(position, J_vehicle, noise);
    oracle.add(position, J_vehicle, noise);
  }
  void remove(Eigen::Index landmark) {
    filter.remove_landmark(landmark);
    oracle.remove(landmark);
  }
  void update(const std::vector<LinearObservation>& observations) {
    const UpdateResult result = filter.update(observations);
    EXPECT_NEAR(result.nis, oracle.update(observations), 1e-9 * (1.0 + result.nis));
    EXPECT_EQ(result.dof, static_cast<int>(2 * observations.size()));
  }

  Ekf filter;
  DenseFilter oracle;
};

Twin random_twin(Rng& rng, Eigen::Index landmarks) {
  Twin twin(landmarks);
  twin.reset({{1.0, -2.0, 0.3}, random_covariance(rng, 3, 0.5)});
  for (Eigen::Index i = 0; i < landmarks; ++i) {
    twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
    twin.add(random_matrix(rng, 2, 1, 5.0), random_matrix(rng, 2, 3, 0.5), random_covariance(rng, 2, 0.3));
  }
  return twin;
}

/// A world in which everything is linear: a vehicle that only shifts, and observations l - p.
TEST(Ekf, LinearWorldEqualsTheDenseFilter) {
  Rng rng(301);
  Rng motion_noise = rng.stream("motion");
  Rng sensor_noise = rng.stream("sensor");
  Rng choice = rng.stream("choice");
  Eigen::Matrix<double, 2, 3> H_vehicle = Eigen::Matrix<double, 2, 3>::Zero();
  H_vehicle.leftCols<2>() = -Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d R = (Eigen::Matrix2d() << 0.04, 0.01, 0.01, 0.09).finished();
  const Eigen::Matrix3d Q = Eigen::Vector3d(0.01, 0.02, 0.0).asDiagonal();
  Eigen::Vector2d vehicle(0.0, 0.0);
  std::vector<Eigen::Vector2d> landmarks;  // the truth, in the filter's order
  Twin twin(2);                            // grows on the way
  twin.reset({});
  const auto observe = [&](const Eigen::Vector2d& landmark) {
    return Eigen::Vector2d(landmark - vehicle + Eigen::Vector2d(sensor_noise.normal(0.2), sensor_noise.normal(0.3)));
  };
  for (int step = 0; step < 200; ++step) {
    const Eigen::Vector2d commanded(0.3 * std::cos(0.05 * step), 0.3 * std::sin(0.05 * step));
    vehicle += commanded + Eigen::Vector2d(motion_noise.normal(0.1), motion_noise.normal(0.14));
    MotionPrediction motion;
    motion.submap_T_vehicle = additive_step(twin.filter.vehicle_pose(), {commanded.x(), commanded.y(), 0.0});
    motion.F.setIdentity();
    motion.Q = Q;
    twin.predict(motion);
    if (step % 3 == 0) {  // a new landmark: l = p + z
      const Eigen::Vector2d landmark = vehicle + Eigen::Vector2d(choice.uniform(-5.0, 5.0), choice.uniform(-5.0, 5.0));
      landmarks.push_back(landmark);
      twin.add(twin.filter.vehicle_pose().translation() + observe(landmark), -H_vehicle, R);
    }
    if (step % 7 == 6) {
      const auto gone = static_cast<Eigen::Index>(choice.below(landmarks.size()));
      twin.remove(gone);
      landmarks[static_cast<std::size_t>(gone)] = landmarks.back();
      landmarks.pop_back();
    }
    if (step % 2 == 0) {
      std::vector<LinearObservation> observations;
      for (std::size_t i = 0; i < landmarks.size(); i += 1 + choice.below(4)) {
        const auto id = static_cast<Eigen::Index>(i);
        const Eigen::Vector2d predicted = twin.filter.landmark_position(id) - twin.filter.vehicle_pose().translation();
        observations.push_back({id, observe(landmarks[i]) - predicted, H_vehicle, Eigen::Matrix2d::Identity(), R});
      }
      if (!observations.empty()) twin.update(observations);
    }
    ASSERT_TRUE(same_state(twin.filter, twin.oracle, kRounding)) << "step " << step;
  }
  EXPECT_EQ(twin.filter.landmarks(), static_cast<Eigen::Index>(landmarks.size()));
  EXPECT_GT(landmarks.size(), 30U);
  // The estimate is the truth within its covariance: 6 sigma of every landmark and of the vehicle.
  const MapState state = twin.filter.state();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const GaussianPoint2 landmark = state.landmark(static_cast<Eigen::Index>(i));
    const Eigen::Vector2d error = landmark.mean - landmarks[i];
    EXPECT_LE(error.dot(landmark.covariance.inverse() * error), 36.0);
  }
}

TEST(Ekf, F1_PendingTransitionsEqualDensePrediction) {
  Rng rng(302);
  Twin twin = random_twin(rng, 9);
  for (int round = 0; round < 10; ++round) {
    for (int step = 0; step < 1 + round; ++step)
      twin.predict(random_motion(rng, twin.filter.vehicle_pose()));  // none of them is read between
    EXPECT_TRUE(same_state(twin.filter, twin.oracle, 1e-11)) << "round " << round;
  }
}

TEST(Ekf, F1_PendingTransitionIsAppliedBeforeEveryUseOfTheCrossCovariance) {
  Rng rng(303);
  Twin twin = random_twin(rng, 5);
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  twin.add(Eigen::Vector2d(1.0, 2.0), random_matrix(rng, 2, 3), random_covariance(rng, 2, 0.3));
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  twin.remove(1);
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  twin.update({random_observation(rng, 3), random_observation(rng, 0)});
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  EXPECT_LE(largest_difference(twin.filter.landmark_vehicle_covariance(), twin.oracle.P.bottomLeftCorner(10, 3)), kRounding);
  EXPECT_TRUE(same_state(twin.filter, twin.oracle, kRounding));
}

TEST(Ekf, F1_ResetForgetsThePendingTransition) {
  Rng rng(304);
  Twin twin = random_twin(rng, 4);
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  twin.reset({{0.5, 0.5, 3.0}, random_covariance(rng, 3, 0.2)});
  twin.add(Eigen::Vector2d(1.0, 2.0), random_matrix(rng, 2, 3), random_covariance(rng, 2, 0.3));
  EXPECT_EQ(twin.filter.landmarks(), 1);
  EXPECT_TRUE(same_state(twin.filter, twin.oracle, kRounding));
}

TEST(Ekf, F2_PredictedObservationsEqualDenseHPHt) {
  Rng rng(305);
  Twin twin = random_twin(rng, 8);
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  const std::vector<Eigen::Index> landmarks{6, 2, 0, 7, 2};  // any order, one of them twice
  PairingProblem problem;
  twin.filter.predict_observations(landmarks, problem);
  ASSERT_EQ(problem.predicted.size(), 10);
  EXPECT_TRUE(problem.second_component_is_angle);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(10, 19);
  for (Eigen::Index i = 0; i < 5; ++i) {
    const Eigen::Index id = landmarks[static_cast<std::size_t>(i)];
    const RangeBearingPrediction h = predict_range_bearing(twin.filter.vehicle_pose(), twin.filter.landmark_position(id));
    H.block<2, 3>(2 * i, 0) = h.H_vehicle;
    H.block<2, 2>(2 * i, 3 + 2 * id) = h.H_landmark;
    EXPECT_EQ((problem.predicted.segment<2>(2 * i)), h.range_bearing);
  }
  EXPECT_LE(largest_difference(problem.predicted_covariance, H * twin.oracle.P * H.transpose()), kRounding);
}

TEST(Ekf, F3_NormalisedInnovationByHand) {
  // Vehicle known exactly, one landmark with variance 3 in x and 1 in y, observed as l - p with variance 1:
  // S = diag(4, 2), residual (2, 1) -> 4/4 + 1/2.
  Ekf filter(1);
  filter.reset({});
  filter.add_landmark(Eigen::Vector2d(5.0, 0.0), Eigen::Matrix<double, 2, 3>::Zero(), Eigen::Vector2d(3.0, 1.0).asDiagonal());
  const UpdateResult result = filter.update({LinearObservation{0, Eigen::Vector2d(2.0, 1.0), Eigen::Matrix<double, 2, 3>::Zero(),
                                                               Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity()}});
  EXPECT_NEAR(result.nis, 1.5, kRounding);
  EXPECT_EQ(result.dof, 2);
  // gain diag(3/4, 1/2): mean (5 + 1.5, 0.5), variance 3/4 and 1/2
  EXPECT_NEAR(filter.landmark_position(0).x(), 6.5, kRounding);
  EXPECT_NEAR(filter.landmark_position(0).y(), 0.5, kRounding);
  EXPECT_NEAR(filter.landmark_covariance(0)(0, 0), 0.75, kRounding);
  EXPECT_NEAR(filter.landmark_covariance(0)(1, 1), 0.5, kRounding);
}

TEST(Ekf, F4_UpdateEqualsJosephForm) {
  Rng rng(306);
  for (int trial = 0; trial < 40; ++trial) {
    const auto landmarks = static_cast<Eigen::Index>(1 + rng.below(12));
    Twin twin = random_twin(rng, landmarks);
    std::vector<LinearObservation> observations;
    for (std::uint64_t i = 0; i <= rng.below(9); ++i) {  // a landmark may be observed twice
      observations.push_back(random_observation(rng, static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(landmarks)))));
    }
    twin.update(observations);
    ASSERT_TRUE(same_state(twin.filter, twin.oracle, kRounding)) << "trial " << trial;
  }
}

TEST(Ekf, F4_UpdateWithMoreObservationsThanTheWorkspaceGrowsIt) {
  Rng rng(307);
  Twin twin = random_twin(rng, 50);
  std::vector<LinearObservation> observations;
  for (Eigen::Index i = 0; i < 45; ++i) observations.push_back(random_observation(rng, i));
  twin.update(observations);
  EXPECT_TRUE(same_state(twin.filter, twin.oracle, 1e-10));
  EXPECT_EQ(twin.filter.update(std::vector<LinearObservation>{}).dof, 0);
}

TEST(Ekf, F4_BearingResidualIsWrapped) {
  // Landmark straight behind at 2 m: predicted bearing -pi (wrapped), measured pi - 0.01: residual -0.01, not 2 pi - 0.01.
  Ekf filter(1);
  filter.reset({});
  filter.add_landmark(Eigen::Vector2d(-2.0, 0.0), Eigen::Matrix<double, 2, 3>::Zero(), 0.04 * Eigen::Matrix2d::Identity());
  Features scan(1);
  scan[0].range_bearing << 2.0, kPi - 0.01;
  scan[0].covariance = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  const UpdateResult result = filter.update(scan, {{0, 0}}, {0});
  // along the bearing the landmark's variance is 0.04 / 2^2 = 0.01: nis = 0.01^2 / (0.01 + 0.0004)
  EXPECT_NEAR(result.nis, 1e-4 / 0.0104, 1e-9);
}

TEST(Ekf, F4_HeadingStaysWrapped) {
  Ekf filter(1);
  filter.reset({{0.0, 0.0, kPi - 0.01}, Eigen::Vector3d(0.0, 0.0, 1.0).asDiagonal()});
  filter.add_landmark(Eigen::Vector2d(1.0, 0.0), Eigen::Matrix<double, 2, 3>::Zero(), Eigen::Matrix2d::Zero());
  Eigen::Matrix<double, 2, 3> H_vehicle = Eigen::Matrix<double, 2, 3>::Zero();
  H_vehicle(0, 2) = 1.0;  // the first component measures the heading with variance 1: half of the residual 0.1 is believed
  (void)filter.update({LinearObservation{0, Eigen::Vector2d(0.1, 0.0), H_vehicle, Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Identity()}});
  EXPECT_NEAR(filter.vehicle_pose().heading, -kPi + 0.04, kRounding);
}

TEST(Ekf, F8_InvariantUpdateEqualsTheDenseOneInInvariantCoordinates) {
  Rng rng(313);
  for (int trial = 0; trial < 40; ++trial) {
    const auto landmarks = static_cast<Eigen::Index>(1 + rng.below(12));
    Ekf filter(landmarks, ErrorForm::kInvariant);
    DenseFilter oracle;
    const GaussianSe2 vehicle{{1.0, -2.0, rng.uniform(-3.0, 3.0)}, random_covariance(rng, 3, 0.5)};
    filter.reset(vehicle);
    oracle = {vehicle.mean.vector(), vehicle.covariance};
    for (Eigen::Index i = 0; i < landmarks; ++i) {
      const Eigen::Vector2d position = random_matrix(rng, 2, 1, 5.0);
      const Eigen::Matrix<double, 2, 3> J = random_matrix(rng, 2, 3, 0.5);
      const Eigen::Matrix2d noise = random_covariance(rng, 2, 0.3);
      filter.add_landmark(position, J, noise);
      oracle.add(position, J, noise);
    }
    for (int update = 0; update < 3; ++update) {
      std::vector<LinearObservation> observations;
      for (std::uint64_t i = 0; i <= rng.below(5); ++i) {
        observations.push_back(random_observation(rng, static_cast<Eigen::Index>(rng.below(static_cast<std::uint64_t>(landmarks)))));
      }
      const double nis = oracle.update_invariantly(observations);
      EXPECT_NEAR(filter.update(observations).nis, nis, 1e-9 * (1.0 + nis));
      ASSERT_TRUE(same_state(filter, oracle, 1e-11)) << "trial " << trial;
    }
  }
}

/// Variance of the heading after landmarks were seen again and again by a vehicle that drove without error, but did not know its
/// heading at the start. No scan can tell it: everything might be turned.
double heading_variance_after_scans(ErrorForm form) {
  constexpr double kHeadingVariance = 0.04;
  Rng rng(314);
  const Eigen::Matrix2d R = Eigen::Vector2d(0.01, 0.0004).asDiagonal();
  Ekf filter(8, form);
  filter.reset({{}, Eigen::Vector3d(0.0, 0.0, kHeadingVariance).asDiagonal()});
  std::vector<Eigen::Vector2d> landmarks;
  for (int i = 0; i < 8; ++i) landmarks.emplace_back(rng.uniform(-8.0, 8.0), rng.uniform(3.0, 8.0));
  Se2 truth;
  const auto look = [&](std::size_t i) {
    Feature feature{predict_range_bearing(truth, landmarks[i]).range_bearing, R, std::nullopt};
    feature.range_bearing += Eigen::Vector2d(rng.normal(0.1), rng.normal(0.02));
    return feature;
  };
  std::vector<Eigen::Index> all;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    filter.add_landmark(look(i));
    all.push_back(static_cast<Eigen::Index>(i));
  }
  for (int scan = 0; scan < 20; ++scan) {
    const Se2 old_T_new{0.3, 0.0, 0.05};
    truth = truth * old_T_new;
    filter.predict({filter.vehicle_pose() * old_T_new, compose_jacobian_left(filter.vehicle_pose(), old_T_new), Eigen::Matrix3d::Zero()});
    Features features;
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      features.push_back(look(i));
      pairs.push_back({all[i], all[i]});
    }
    (void)filter.update(features, pairs, all);
  }
  return filter.vehicle_covariance()(2, 2) / kHeadingVariance;
}

TEST(Ekf, F8_HeadingIsNotGainedOutOfNothing) {
  EXPECT_NEAR(heading_variance_after_scans(ErrorForm::kInvariant), 1.0, 1e-9);
  const double additive = heading_variance_after_scans(ErrorForm::kAdditive);  // what the textbook filter believes to have learned
  RecordProperty("additive_heading_variance_ratio", std::to_string(additive));
  EXPECT_LT(additive, 0.99);
}

TEST(Ekf, F5_AddedLandmarkIsCorrelatedThroughTheVehicle) {
  // p ~ N(0, diag(1, 4, 0)); l = p + z with z variance 1: P_l = diag(2, 5), Cov(l, p) = diag(1, 4); two of them share the vehicle.
  Ekf filter(1);
  filter.reset({{}, Eigen::Vector3d(1.0, 4.0, 0.0).asDiagonal()});
  Eigen::Matrix<double, 2, 3> J = Eigen::Matrix<double, 2, 3>::Zero();
  J.leftCols<2>().setIdentity();
  filter.add_landmark(Eigen::Vector2d(3.0, 0.0), J, Eigen::Matrix2d::Identity());
  filter.add_landmark(Eigen::Vector2d(0.0, 3.0), J, Eigen::Matrix2d::Identity());
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(7, 7);
  expected.diagonal() << 1.0, 4.0, 0.0, 2.0, 5.0, 2.0, 5.0;
  for (const auto& [row, column, value] : {std::tuple{3, 0, 1.0}, {4, 1, 4.0}, {5, 0, 1.0}, {6, 1, 4.0}, {5, 3, 1.0}, {6, 4, 4.0}}) {
    expected(row, column) = expected(column, row) = value;
  }
  EXPECT_LE(largest_difference(filter.state().covariance, expected), kRounding);
}

TEST(Ekf, F5_FeatureBecomesALandmarkThroughItsInverseModel) {
  Rng rng(308);
  Ekf filter(2);
  const GaussianSe2 vehicle{{2.0, 1.0, kPi / 2.0}, random_covariance(rng, 3, 0.1)};
  filter.reset(vehicle);
  Feature feature;
  feature.range_bearing << 4.0, kPi / 2.0;  // looking along +y, the landmark is to the left: at (2 - 4, 1)
  feature.covariance << 0.01, 0.001, 0.001, 0.0004;
  filter.add_landmark(feature);
  EXPECT_LE((filter.landmark_position(0) - Eigen::Vector2d(-2.0, 1.0)).norm(), kRounding);
  // t = pi: dl/d(x, y, heading) = [1 0 0; 0 1 -4], dl/d(r, bearing) = [-1 0; 0 -4]
  Eigen::Matrix<double, 2, 3> J;
  J << 1.0, 0.0, 0.0, 0.0, 1.0, -4.0;
  const Eigen::Matrix2d J_z = Eigen::Vector2d(-1.0, -4.0).asDiagonal();
  EXPECT_LE(largest_difference(filter.landmark_covariance(0),
                               J * vehicle.covariance * J.transpose() + J_z * feature.covariance * J_z.transpose()),
            kRounding);
  EXPECT_LE(largest_difference(filter.landmark_vehicle_covariance(), J * vehicle.covariance), kRounding);
}

TEST(Ekf, F6_RemovalIsMarginalisation) {
  Rng rng(309);
  for (const Eigen::Index gone : {0, 2, 5, 6}) {  // the first, one in the middle, the last but one, the last
    Twin twin = random_twin(rng, 7);
    twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
    twin.remove(gone);
    EXPECT_TRUE(same_state(twin.filter, twin.oracle, 1e-14)) << "landmark " << gone;
    twin.update({random_observation(rng, 0), random_observation(rng, 5)});
    EXPECT_TRUE(same_state(twin.filter, twin.oracle, kRounding)) << "landmark " << gone;
  }
}

TEST(Ekf, F6_RemovingWhatIsNotThereIsRefused) {
  Rng rng(310);
  Twin twin = random_twin(rng, 2);
  EXPECT_THROW(twin.filter.remove_landmark(2), InvalidArgument);
  EXPECT_THROW(twin.filter.remove_landmark(-1), InvalidArgument);
  twin.remove(0);
  twin.remove(0);
  EXPECT_EQ(twin.filter.landmarks(), 0);
  EXPECT_TRUE(same_state(twin.filter, twin.oracle, kRounding));
}

/// What a refused update leaves behind: everything as before.
void expect_refused(Twin& twin, const std::vector<LinearObservation>& observations, const std::string& names) {
  try {
    (void)twin.filter.update(observations);
    FAIL() << "accepted: " << names;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(names), std::string::npos) << error.what();
  }
  EXPECT_TRUE(same_state(twin.filter, twin.oracle, kRounding));
}

TEST(Ekf, F3_NotPositiveDefiniteNamesTheLandmark) {
  Rng rng(311);
  Twin twin = random_twin(rng, 6);
  twin.predict(random_motion(rng, twin.filter.vehicle_pose()));
  LinearObservation bad = random_observation(rng, 4);
  bad.R = -1000.0 * Eigen::Matrix2d::Identity();
  EXPECT_THROW((void)twin.filter.update({random_observation(rng, 1), bad}), NotPositiveDefinite);
  expect_refused(twin, {random_observation(rng, 1), bad}, "innovation covariance is not positive definite (landmark 4 of the map)");
}

TEST(Ekf, F3_IndefiniteStateCovarianceIsRefused) {
  Ekf filter(1);
  filter.reset({{}, Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal()});
  filter.add_landmark(Eigen::Vector2d(1.0, 0.0), Eigen::Matrix<double, 2, 3>::Zero(), 1e-6 * Eigen::Matrix2d::Identity());
  Eigen::Matrix<double, 2, 3> H_vehicle = Eigen::Matrix<double, 2, 3>::Zero();
  H_vehicle(1, 2) = 1.0;  // sees the heading's variance of -1
  EXPECT_THROW((void)filter.update({LinearObservation{0, Eigen::Vector2d::Zero(), H_vehicle, Eigen::Matrix2d::Identity(),
                                                      0.01 * Eigen::Matrix2d::Identity()}}),
               NotPositiveDefinite);
}

TEST(Ekf, F3_NotANumberIsRefused) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  Rng rng(312);
  Twin twin = random_twin(rng, 3);
  LinearObservation bad = random_observation(rng, 2);
  bad.R(0, 0) = kNaN;
  expect_refused(twin, {bad}, "landmark 2");
  bad = random_observation(rng, 2);
  bad.H_landmark(1, 0) = kNaN;
  expect_refused(twin, {bad}, "landmark 2");
  bad = random_observation(rng, 2);
  bad.residual(1) = kNaN;
  expect_refused(twin, {random_observation(rng, 0), bad}, "landmark 2");
}

}  // namespace
}  // namespace ssjs
