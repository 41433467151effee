#include "ssjs/joining/sparse_solver.hpp"

#include <gtest/gtest.h>

#include <string>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::correlated_covariance;
using testing::jacobians_agree;
using testing::kJacobianPoints;
using testing::numeric_jacobian;
using testing::random_pose;
using testing::state_sigmas;

PortFactor random_factor(Rng& rng, int base, const std::vector<int>& ports, const std::vector<Se2>& truth, double sigma_m) {
  PortFactor factor;
  factor.base = base;
  factor.ports = ports;
  const auto n = static_cast<Eigen::Index>(ports.size());
  const Eigen::MatrixXd P = correlated_covariance(rng, state_sigmas(n, 0, sigma_m));
  const Eigen::VectorXd error = P.llt().matrixL() * testing::normal_vector(rng, 3 * n);
  factor.mean.resize(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Se2 port = truth[static_cast<std::size_t>(base)].inverse() * truth[static_cast<std::size_t>(ports[static_cast<std::size_t>(i)])];
    factor.mean.segment<3>(3 * i) = additive_step(port, error.segment<3>(3 * i)).vector();
  }
  factor.information = P.inverse();
  return factor;
}

/// Eight bases on a ring, its chain of links and two maps with several ports.
struct Ring {
  std::vector<Se2> truth{Se2{}};
  std::vector<Se2> start{Se2{}};
  std::map<int, PortFactor> factors;

  Ring(Rng& rng, double sigma_m) {
    for (int k = 1; k < 8; ++k) truth.push_back(truth.back() * Se2{5.0, 0.3, 0.8});
    factors[0] = random_factor(rng, 0, {1, 4, 5}, truth, sigma_m);
    for (const int k : {1, 3, 5, 6}) factors[k] = random_factor(rng, k, {k + 1}, truth, sigma_m);
    factors[2] = random_factor(rng, 2, {3, 7}, truth, sigma_m);
    for (std::size_t k = 1; k < truth.size(); ++k) {
      start.push_back(additive_step(truth[k], Eigen::Vector3d(rng.normal(sigma_m), rng.normal(sigma_m), rng.normal(0.1 * sigma_m))));
    }
  }
  /// Whitened residuals of all factors, bases 1 to 7 at x.
  [[nodiscard]] Eigen::VectorXd whitened(const Eigen::VectorXd& x) const {
    const auto pose = [&](int k) { return k == 0 ? Se2{} : Se2::from_vector(x.segment<3>(3 * (k - 1))); };
    std::vector<double> all;
    for (const auto& [base, factor] : factors) {
      std::vector<Se2> ports;
      for (const int port : factor.ports) ports.push_back(pose(port));
      const Eigen::MatrixXd U = factor.information.llt().matrixU();
      const Eigen::VectorXd r = U * port_residual(factor, pose(base), ports).residual;
      all.insert(all.end(), r.data(), r.data() + r.size());
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }
};

Eigen::VectorXd stacked(const std::vector<Se2>& poses) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(3 * (poses.size() - 1)));
  for (std::size_t k = 1; k < poses.size(); ++k) x.segment<3>(static_cast<Eigen::Index>(3 * (k - 1))) = poses[k].vector();
  return x;
}

TEST(SparseSolver, J4_PortResidualJacobian) {
  Rng rng(441);
  for (int point = 0; point < kJacobianPoints; ++point) {
    const std::vector<Se2> poses{random_pose(rng, point), random_pose(rng, point + 1), random_pose(rng, point + 2)};
    const PortFactor factor = random_factor(rng, 0, {1, 2}, poses, 0.5);  // residuals of half a metre
    Eigen::VectorXd x(9);
    x << poses[0].vector(), poses[1].vector(), poses[2].vector();
    const auto residual = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
      return port_residual(factor, Se2::from_vector(v.head<3>()), {Se2::from_vector(v.segment<3>(3)), Se2::from_vector(v.tail<3>())})
          .residual;
    };
    const PortResidual at = port_residual(factor, poses[0], {poses[1], poses[2]});
    EXPECT_GT(at.residual.norm(), 0.0);
    EXPECT_TRUE(jacobians_agree(at.J, numeric_jacobian(residual, x, {2, 5}))) << point;
  }
}

TEST(SparseSolver, J4_ResidualHeadingIsWrapped) {
  PortFactor factor{0, {1}, Eigen::Vector3d(1.0, 2.0, kPi - 0.1), Eigen::Matrix3d::Identity()};
  const PortResidual at = port_residual(factor, {}, {{1.5, 2.0, -kPi + 0.1}});
  EXPECT_NEAR(at.residual(0), 0.5, 1e-12);
  EXPECT_NEAR(at.residual(2), 0.2, 1e-12);
}

TEST(SparseSolver, J16_EqualsDenseGaussNewton) {
  Rng rng(442);
  for (int trial = 0; trial < 5; ++trial) {
    const Ring ring(rng, 0.2);
    const auto residual = [&](const Eigen::VectorXd& x) { return ring.whitened(x); };
    Eigen::VectorXd x = stacked(ring.start);
    Eigen::MatrixXd information;
    for (int iteration = 0; iteration < 30; ++iteration) {
      const Eigen::MatrixXd J = numeric_jacobian(residual, x);
      information = J.transpose() * J;
      x -= information.ldlt().solve(J.transpose() * residual(x));
    }
    const double cost = 0.5 * residual(x).squaredNorm();

    std::vector<Se2> poses = ring.start;
    SparsePoseSolver solver;
    EXPECT_NEAR(solver.optimize(ring.factors, poses, 1e-12), cost, 1e-6 * (1.0 + cost));
    EXPECT_EQ(poses[0].vector(), Eigen::Vector3d::Zero());
    const Eigen::MatrixXd covariance = information.inverse();
    Eigen::VectorXd difference = stacked(poses) - x;
    for (Eigen::Index i = 2; i < difference.size(); i += 3) difference(i) = wrap_angle(difference(i));
    EXPECT_LE((difference.array() / covariance.diagonal().array().sqrt()).abs().maxCoeff(), 1e-4);
    EXPECT_LE(testing::covariance_difference(solver.covariance({1, 2, 3, 4, 5, 6, 7}), covariance), 1e-4);
  }
}

TEST(SparseSolver, J16_FactorizeAnswersWhereThePosesAre) {
  Rng rng(443);
  const Ring ring(rng, 0.2);
  const auto residual = [&](const Eigen::VectorXd& x) { return ring.whitened(x); };
  const Eigen::MatrixXd J = numeric_jacobian(residual, stacked(ring.start));
  const Eigen::MatrixXd expected = (J.transpose() * J).inverse();
  SparsePoseSolver solver;
  solver.factorize(ring.factors, ring.start);
  EXPECT_LE(testing::covariance_difference(solver.covariance({1, 2, 3, 4, 5, 6, 7}), expected), 1e-6);
  // any subset, in any order, with the exactly known base 0 in between
  const Eigen::MatrixXd some = solver.covariance({5, 0, 2});
  EXPECT_LE((some.block<3, 3>(0, 6) - expected.block<3, 3>(12, 3)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(some.middleRows<3>(3).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(solver.covariance({0}).cwiseAbs().maxCoeff(), 0.0);
}

TEST(SparseSolver, J16_ABadStartIsMended) {
  Rng rng(444);
  const Ring ring(rng, 0.05);
  std::vector<Se2> near = ring.start;
  std::vector<Se2> far = ring.start;
  for (std::size_t k = 1; k < far.size(); ++k)
    far[k] = additive_step(far[k], Eigen::Vector3d(rng.normal(3.0), rng.normal(3.0), rng.normal(0.4)));
  SparsePoseSolver solver;
  const double cost = solver.optimize(ring.factors, near, 1e-12);
  EXPECT_NEAR(solver.optimize(ring.factors, far, 1e-12), cost, 1e-6 * (1.0 + cost));
  for (std::size_t k = 1; k < far.size(); ++k) EXPECT_LE(additive_difference(far[k], near[k]).norm(), 1e-4);
}

TEST(SparseSolver, ABaseThatNothingHoldsIsNamed) {
  Rng rng(445);
  Ring ring(rng, 0.1);
  ring.factors[6].information.setZero();  // base 7 is held by the map at base 2
  SparsePoseSolver solver;
  EXPECT_NO_THROW(solver.factorize(ring.factors, ring.start));
  ring.factors[2].information.setZero();  // now by nothing, and so is base 3, but for its own link to 4
  try {
    solver.factorize(ring.factors, ring.start);
    FAIL() << "a base was found without information";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(std::string(error.what()),
              "information matrix of the bases is not positive definite (base 7 is not held by any port factor)");
  }
}

TEST(SparseSolver, NotANumberIsRefused) {
  Rng rng(446);
  Ring ring(rng, 0.1);
  ring.factors[3].information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  SparsePoseSolver solver;
  EXPECT_THROW(solver.factorize(ring.factors, ring.start), NotPositiveDefinite);
}

TEST(SparseSolver, AskingForAnUnknownBaseIsRefused) {
  Rng rng(447);
  const Ring ring(rng, 0.1);
  SparsePoseSolver solver;
  solver.factorize(ring.factors, ring.start);
  EXPECT_THROW((void)solver.covariance({1, 9}), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
