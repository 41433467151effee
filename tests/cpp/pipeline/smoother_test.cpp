#include "ssjs/pipeline/smoother.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <string>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

using testing::correlated_covariance;
using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;

/// A round of twelve poses among six landmarks, every measurement with noise of its own covariance.
struct Round {
  std::vector<Se2> truth{Se2{}};
  std::vector<Eigen::Vector2d> landmarks;
  SmoothingProblem problem;

  explicit Round(std::uint64_t seed, double noise = 1.0) {
    Rng rng(seed);
    for (int k = 1; k < 12; ++k) truth.push_back(truth.back() * Se2{2.0, 0.1, 2.0 * kPi / 12.0});
    for (int l = 0; l < 6; ++l) landmarks.emplace_back(rng.uniform(-4.0, 8.0), rng.uniform(-2.0, 10.0));
    problem.poses = {Se2{}};
    for (int k = 0; k + 1 < 12; ++k) {
      const Eigen::MatrixXd P = correlated_covariance(rng, Eigen::Vector3d(0.1, 0.1, 0.03));
      const Eigen::Vector3d error = P.llt().matrixL() * Eigen::VectorXd(noise * testing::normal_vector(rng, 3));
      const Se2 step = truth[static_cast<std::size_t>(k)].inverse() * truth[static_cast<std::size_t>(k) + 1];
      problem.motions.push_back({k, k + 1, {additive_step(step, error), P}});
      problem.poses.push_back(problem.poses.back() * problem.motions.back().from_T_to.mean);
    }
    for (int l = 0; l < 6; ++l) {
      for (int k = l % 2; k < 12; k += 2) {
        const Eigen::MatrixXd R = correlated_covariance(rng, Eigen::Vector2d(0.1, 0.02));
        const Eigen::Vector2d error = R.llt().matrixL() * Eigen::VectorXd(noise * testing::normal_vector(rng, 2));
        Eigen::Vector2d seen =
            predict_range_bearing(truth[static_cast<std::size_t>(k)], landmarks[static_cast<std::size_t>(l)]).range_bearing + error;
        seen.y() = wrap_angle(seen.y());
        problem.sightings.push_back({k, l, seen, R});
      }
      const SightingFactor& last = problem.sightings.back();
      problem.landmarks.push_back(
          landmark_from_range_bearing(problem.poses[static_cast<std::size_t>(last.pose)], last.range_bearing).submap_p_landmark);
    }
  }
};

Eigen::VectorXd stacked(const std::vector<Se2>& poses, const std::vector<Eigen::Vector2d>& landmarks) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(3 * (poses.size() - 1) + 2 * landmarks.size()));
  Eigen::Index row = 0;
  for (std::size_t k = 1; k < poses.size(); ++k, row += 3) x.segment<3>(row) = poses[k].vector();
  for (const Eigen::Vector2d& landmark : landmarks) {
    x.segment<2>(row) = landmark;
    row += 2;
  }
  return x;
}

/// Whitened residuals of the whole problem, written down without the code under test.
Eigen::VectorXd whitened(const SmoothingProblem& problem, const Eigen::VectorXd& x) {
  const auto first_landmark = static_cast<Eigen::Index>(3 * (problem.poses.size() - 1));
  const auto pose = [&](int k) { return k == 0 ? Se2{} : Se2::from_vector(x.segment<3>(3 * (k - 1))); };
  std::vector<double> all;
  const auto append = [&all](const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance) {
    const Eigen::VectorXd white = covariance.llt().matrixL().solve(residual);
    all.insert(all.end(), white.data(), white.data() + white.size());
  };
  for (const MotionFactor& motion : problem.motions) {
    append(additive_difference(pose(motion.from).inverse() * pose(motion.to), motion.from_T_to.mean), motion.from_T_to.covariance);
  }
  for (const SightingFactor& sighting : problem.sightings) {
    const Eigen::Vector2d seen = pose(sighting.pose).inverse() * Eigen::Vector2d(x.segment<2>(first_landmark + 2 * sighting.landmark));
    append(Eigen::Vector2d(seen.norm() - sighting.range_bearing.x(),
                           angle_difference(std::atan2(seen.y(), seen.x()), sighting.range_bearing.y())),
           sighting.covariance);
  }
  return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

TEST(Smoother, B2_MotionJacobians) {
  Rng rng(911);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 from = random_pose(rng, point);
    const Se2 to = random_pose(rng, point + 1);
    const MotionFactor factor{0, 1, {additive_step(from.inverse() * to, Eigen::Vector3d(0.7, -0.4, 0.3)), Eigen::Matrix3d::Identity()}};
    const MotionResidual residual = motion_residual(factor, from, to);
    EXPECT_NEAR(residual.residual.z(), -0.3, 1e-9);
    const auto by_from = [&](const Eigen::Vector3d& v) { return motion_residual(factor, Se2::from_vector(v), to).residual; };
    const auto by_to = [&](const Eigen::Vector3d& v) { return motion_residual(factor, from, Se2::from_vector(v)).residual; };
    EXPECT_TRUE(jacobians_agree(residual.J_from, numeric_jacobian(by_from, from.vector(), {2})));
    EXPECT_TRUE(jacobians_agree(residual.J_to, numeric_jacobian(by_to, to.vector(), {2})));
  }
}

TEST(Smoother, B3_SightingJacobians) {
  Rng rng(912);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const Se2 pose = random_pose(rng, point);
    const double bearing = point % 3 == 0 ? kPi + rng.uniform(-1e-4, 1e-4) : rng.uniform(-kPi, kPi);
    const Eigen::Vector2d landmark = landmark_from_range_bearing(pose, {rng.uniform(1.5, 40.0), bearing}).submap_p_landmark;
    const SightingFactor factor{0, 0, {12.0, wrap_angle(bearing + 0.4)}, Eigen::Matrix2d::Identity()};
    const SightingResidual residual = sighting_residual(factor, pose, landmark);
    EXPECT_NEAR(residual.residual.y(), -0.4, 1e-9);
    const auto by_pose = [&](const Eigen::Vector3d& v) { return sighting_residual(factor, Se2::from_vector(v), landmark).residual; };
    const auto by_landmark = [&](const Eigen::Vector2d& v) { return sighting_residual(factor, pose, v).residual; };
    EXPECT_TRUE(jacobians_agree(residual.J_pose, numeric_jacobian(by_pose, pose.vector(), {1})));
    EXPECT_TRUE(jacobians_agree(residual.J_landmark, numeric_jacobian(by_landmark, landmark, {1})));
  }
}

TEST(Smoother, B5_TheWeightIsTheSlopeOfTheCost) {
  constexpr double kWidth = 1.5;
  for (const RobustKernel kernel : {RobustKernel::kNone, RobustKernel::kHuber, RobustKernel::kCauchy}) {
    for (const double squared : {0.1, 1.0, 2.2499, 2.2501, 9.0, 400.0}) {
      const double h = 1e-6;
      const double slope =
          (robust_loss(kernel, kWidth, squared + h).cost - robust_loss(kernel, kWidth, squared - h).cost) / h;  // by half the square: h
      EXPECT_NEAR(robust_loss(kernel, kWidth, squared).weight, slope, 1e-6);
    }
  }
  EXPECT_DOUBLE_EQ(robust_loss(RobustKernel::kHuber, 2.0, 25.0).cost, 2.0 * (5.0 - 1.0));    // k (s - k/2)
  EXPECT_DOUBLE_EQ(robust_loss(RobustKernel::kCauchy, 2.0, 4.0).cost, 2.0 * std::log(2.0));  // k^2/2 ln(1 + s^2/k^2)
  EXPECT_DOUBLE_EQ(robust_loss(RobustKernel::kHuber, 2.0, 3.0).cost, 1.5);                   // inside: as without
}

TEST(Smoother, B6_B9_MeanAndCovarianceEqualTheDenseBatchSolution) {
  for (const std::uint64_t seed : {921, 922, 923}) {
    const Round round(seed);
    const SmoothingProblem& problem = round.problem;
    Eigen::VectorXd x = stacked(problem.poses, problem.landmarks);
    const auto residual = [&](const Eigen::VectorXd& v) { return whitened(problem, v); };
    Eigen::MatrixXd J;
    for (int iteration = 0; iteration < 30; ++iteration) {  // plain Gauss-Newton with numeric Jacobians
      J = numeric_jacobian(residual, x);
      x -= (J.transpose() * J).ldlt().solve(J.transpose() * residual(x));
    }
    Smoother smoother(problem, {});
    const SmoothingReport report = smoother.optimize();
    EXPECT_TRUE(report.converged);
    EXPECT_NEAR(report.half_chi_squared_initial, 0.5 * residual(stacked(problem.poses, problem.landmarks)).squaredNorm(), 1e-6);
    EXPECT_NEAR(report.half_chi_squared_final, 0.5 * residual(x).squaredNorm(), 1e-6);
    Eigen::VectorXd difference = stacked(smoother.poses(), smoother.landmarks()) - x;
    for (Eigen::Index k = 2; k < 33; k += 3) difference(k) = wrap_angle(difference(k));
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4);  // the last step that promises less than 1e-7 of half chi-squared is not taken
    smoother.find_covariances();
    const Eigen::MatrixXd P = (J.transpose() * J).inverse();
    const double tolerance = 1e-4 * P.cwiseAbs().maxCoeff();
    for (int k = 1; k < 12; ++k)
      EXPECT_LE((smoother.pose_covariance(k) - P.block<3, 3>(3 * k - 3, 3 * k - 3)).cwiseAbs().maxCoeff(), tolerance);
    for (int k = 1; k < 11; ++k) {
      EXPECT_LE((smoother.joint_covariance(k, k + 1) - P.block<6, 6>(3 * k - 3, 3 * k - 3)).cwiseAbs().maxCoeff(), tolerance);
    }
    for (int l = 0; l < 6; ++l) {
      EXPECT_LE((smoother.landmark_covariance(l) - P.block<2, 2>(33 + 2 * l, 33 + 2 * l)).cwiseAbs().maxCoeff(), tolerance);
    }
    EXPECT_TRUE(smoother.pose_covariance(0).isZero(0.0));
  }
}

TEST(Smoother, B5_RobustKernelsResistOutliers) {
  Round round(931, 0.2);
  for (std::size_t i = 3; i < round.problem.sightings.size(); i += 9) round.problem.sightings[i].range_bearing.x() += 6.0;
  const auto worst = [&](RobustKernel kernel) {
    SmoothingConfig config;
    config.kernel = kernel;
    Smoother smoother(round.problem, config);
    const SmoothingReport report = smoother.optimize();
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.doubted, kernel == RobustKernel::kNone ? 0 : 4);
    double error = 0.0;
    for (std::size_t l = 0; l < 6; ++l) error = std::max(error, (smoother.landmarks()[l] - round.landmarks[l]).norm());
    return error;
  };
  const double plain = worst(RobustKernel::kNone);
  EXPECT_GT(plain, 0.5);
  EXPECT_LT(worst(RobustKernel::kHuber), 0.5 * plain);
  EXPECT_LT(worst(RobustKernel::kCauchy), 0.1 * plain);
}

TEST(Smoother, WithoutLandmarksItIsDeadReckoning) {
  SmoothingProblem problem = Round(941).problem;
  problem.landmarks.clear();
  problem.sightings.clear();
  GaussianSe2 expected;
  for (const MotionFactor& motion : problem.motions) expected = compose_independent(expected, motion.from_T_to);
  problem.poses[5].x += 3.0;  // a start beside the answer
  Smoother smoother(problem, {});
  EXPECT_NEAR(smoother.optimize().half_chi_squared_final, 0.0, 1e-6);
  smoother.find_covariances();
  EXPECT_LE(additive_difference(smoother.poses().back(), expected.mean).norm(), 1e-5);
  EXPECT_LE((smoother.pose_covariance(11) - expected.covariance).cwiseAbs().maxCoeff(), 1e-5 * expected.covariance.maxCoeff());

  Smoother alone({{Se2{}}, {}, {}, {}}, {});
  EXPECT_TRUE(alone.optimize().converged);
  alone.find_covariances();
  EXPECT_TRUE(alone.pose_covariance(0).isZero(0.0));
}

TEST(Smoother, SaysWhatIsWrong) {
  SmoothingProblem loose = Round(951).problem;
  loose.landmarks.emplace_back(1.0, 1.0);
  try {
    (void)Smoother(loose, {}).optimize();
    FAIL() << "a landmark nobody sees was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_NE(std::string(error.what()).find("landmark 6 is not held by any factor"), std::string::npos) << error.what();
  }
  SmoothingProblem foreign = Round(951).problem;
  foreign.sightings[0].landmark = 6;
  EXPECT_THROW(Smoother(foreign, {}), InvalidArgument);
  SmoothingProblem exact = Round(951).problem;
  exact.motions[2].from_T_to.covariance.setZero();
  EXPECT_THROW(Smoother(exact, {}), NotPositiveDefinite);
}

}  // namespace
}  // namespace ssjs
