#include "ssjs/joining/relative_map.hpp"

#include <gtest/gtest.h>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::BatchSolution;
using testing::solve_batch;

/// tau_ij of links stacked in a vector.
Se2 tau(const Eigen::VectorXd& links, int i, int j) {
  Se2 i_T_j;
  for (int k = i; k < j; ++k) i_T_j = i_T_j * Se2::from_vector(links.segment<3>(3 * Eigen::Index{k}));
  return i_T_j;
}

struct Ring {
  std::vector<GaussianSe2> links;
  explicit Ring(int count, double sigma_m, Rng& rng) {
    for (int k = 0; k < count; ++k) {
      const Eigen::MatrixXd P = testing::correlated_covariance(rng, Eigen::Vector3d(sigma_m, sigma_m, 0.1 * sigma_m));
      const Eigen::Vector3d error = P.llt().matrixL() * testing::normal_vector(rng, 3);
      links.push_back({additive_step({6.0, 0.0, 2.0 * kPi / 10.0}, error), P});
    }
  }
  [[nodiscard]] RelativeMap map() const {
    RelativeMap map;
    for (const GaussianSe2& link : links) map.append(link);
    return map;
  }
  [[nodiscard]] Eigen::VectorXd mean() const {
    Eigen::VectorXd x(static_cast<Eigen::Index>(3 * links.size()));
    for (std::size_t k = 0; k < links.size(); ++k) x.segment<3>(static_cast<Eigen::Index>(3 * k)) = links[k].mean.vector();
    return x;
  }
};

struct Loop {
  int i, j;
  GaussianSe2 i_T_j;
};

/// Links and loops as one least-squares problem, to the end.
BatchSolution batch_of(const Ring& ring, const std::vector<Loop>& loops) {
  const Eigen::VectorXd prior = ring.mean();
  const Eigen::Index n = prior.size();
  const auto rows = static_cast<Eigen::Index>(n + 3 * static_cast<Eigen::Index>(loops.size()));
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
  for (std::size_t k = 0; k < ring.links.size(); ++k) {
    P.block<3, 3>(static_cast<Eigen::Index>(3 * k), static_cast<Eigen::Index>(3 * k)) = ring.links[k].covariance;
  }
  for (std::size_t l = 0; l < loops.size(); ++l) {
    P.block<3, 3>(n + static_cast<Eigen::Index>(3 * l), n + static_cast<Eigen::Index>(3 * l)) = loops[l].i_T_j.covariance;
  }
  return solve_batch(
      prior,
      [&](const Eigen::VectorXd& x) {
        Eigen::VectorXd r(rows);
        r.head(n) = x - prior;
        for (Eigen::Index k = 2; k < n; k += 3) r(k) = wrap_angle(r(k));
        for (std::size_t l = 0; l < loops.size(); ++l) {
          r.segment<3>(n + static_cast<Eigen::Index>(3 * l)) = additive_difference(tau(x, loops[l].i, loops[l].j), loops[l].i_T_j.mean);
        }
        return r;
      },
      P);
}

void expect_equal(const RelativeMap& map, const BatchSolution& batch, double sigmas) {
  const auto n = static_cast<int>(batch.y.size() / 3);
  Eigen::VectorXd links(batch.y.size());
  for (int k = 0; k < n; ++k) links.segment<3>(3 * Eigen::Index{k}) = map.link(k).vector();
  EXPECT_LE(testing::difference_in_sigmas(links, batch.y, n, batch.covariance), sigmas);
  EXPECT_LE(testing::covariance_difference(map.covariance(), batch.covariance), sigmas);
}

TEST(RelativeMap, H1_RelativePosesCarryTheCovarianceOfTheChain) {
  Rng rng(531);
  const Ring ring(8, 0.2, rng);
  RelativeMap map = ring.map();
  map.observe(6, {{1, {{1.0, 18.0, 3.0}, 0.04 * Eigen::Matrix3d::Identity()}}}, 10);  // so that links are correlated
  Eigen::VectorXd links(24);
  for (int k = 0; k < 8; ++k) links.segment<3>(3 * Eigen::Index{k}) = map.link(k).vector();
  const auto relative = [&](int i, int j) { return [i, j](const Eigen::VectorXd& x) -> Eigen::VectorXd { return tau(x, i, j).vector(); }; };
  for (int j = 0; j <= 8; ++j) {
    const std::vector<GaussianSe2> all = map.all_relative_to(j);
    ASSERT_EQ(all.size(), static_cast<std::size_t>(j) + 1);
    for (int i = 0; i <= j; ++i) {
      const Eigen::MatrixXd J = testing::numeric_jacobian(relative(i, j), links, {2});
      const Eigen::Matrix3d expected = J * map.covariance() * J.transpose();
      const GaussianSe2 one = map.relative(i, j);
      EXPECT_LE(additive_difference(one.mean, tau(links, i, j)).norm(), 1e-12);
      EXPECT_LE((one.covariance - expected).norm(), 1e-6);
      EXPECT_LE((all[static_cast<std::size_t>(i)].covariance - one.covariance).norm(), 1e-12);
      EXPECT_LE(additive_difference(all[static_cast<std::size_t>(i)].mean, one.mean).norm(), 1e-12);
    }
  }
  const auto bases = [](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    Eigen::VectorXd X(27);
    for (int k = 0; k <= 8; ++k) X.segment<3>(3 * Eigen::Index{k}) = tau(x, 0, k).vector();
    return X;
  };
  const Eigen::MatrixXd J = testing::numeric_jacobian(bases, links, {5, 8, 11, 14, 17, 20, 23, 26});
  EXPECT_LE((map.base_covariance() - J * map.covariance() * J.transpose()).cwiseAbs().maxCoeff(), 1e-6);
  for (int k = 0; k <= 8; ++k) EXPECT_LE(additive_difference(map.global_T_base(k), tau(links, 0, k)).norm(), 1e-12);
}

TEST(RelativeMap, H2_OneLoopIsTheOptimumWhateverTheNoise) {
  // 0.5 m and 3 degrees a link: far from linear, yet one iterated constraint finds the minimum of the same cost.
  Rng rng(532);
  for (int run = 0; run < 10; ++run) {
    const Ring ring(10, 0.5, rng);
    const Loop loop{0, 10, {{0.3, -0.2, 0.02}, 0.01 * Eigen::Matrix3d::Identity()}};
    RelativeMap map = ring.map();
    map.observe(loop.j, {{loop.i, loop.i_T_j}}, 50);
    expect_equal(map, batch_of(ring, {loop}), 1e-5);
  }
}

TEST(RelativeMap, H2_H3_ChainedLoopsAreTheBatchWhereTheWorldIsLinear) {
  Rng rng(533);
  const Ring ring(20, 0.001, rng);
  RelativeMap map = ring.map();
  std::vector<Loop> loops;
  for (const auto& [i, j] : std::vector<std::pair<int, int>>{{0, 10}, {1, 11}, {3, 13}, {2, 12}, {9, 19}, {4, 14}, {0, 20}}) {
    const Eigen::MatrixXd P = testing::correlated_covariance(rng, Eigen::Vector3d(0.001, 0.001, 0.0001));
    const Eigen::Vector3d error = P.llt().matrixL() * testing::normal_vector(rng, 3);
    loops.push_back({i, j, {additive_step(Se2{}, error), P}});
    map.observe(j, {{i, loops.back().i_T_j}}, 10);
  }
  expect_equal(map, batch_of(ring, loops), 0.01);
}

TEST(RelativeMap, H2_LoopsOfOneBaseStackedAreTheOptimumWhateverTheNoise) {
  // As above with four loops to the newest base at once.
  Rng rng(535);
  for (int run = 0; run < 5; ++run) {
    const Ring ring(12, 0.3, rng);
    std::vector<Loop> loops;
    std::vector<ObservedLink> observed;
    for (const int i : {4, 0, 2, 1}) {  // in no order
      Se2 expected;
      for (int k = i; k < 12; ++k) expected = expected * ring.links[static_cast<std::size_t>(k)].mean;
      const Eigen::MatrixXd P = testing::correlated_covariance(rng, Eigen::Vector3d(0.1, 0.1, 0.02));
      const Eigen::Vector3d error = Eigen::Vector3d(0.5, -0.4, 0.1) + Eigen::Vector3d(P.llt().matrixL() * testing::normal_vector(rng, 3));
      loops.push_back({i, 12, {additive_step(expected, error), P}});
      observed.push_back({i, loops.back().i_T_j});
    }
    RelativeMap map = ring.map();
    map.observe(12, observed, 50);
    expect_equal(map, batch_of(ring, loops), 1e-5);
    EXPECT_LE((map.covariance() - map.covariance().transpose()).norm(), 0.0);
    for (int k = 0; k <= 12; ++k) {
      Se2 global_T_base;
      for (int link = 0; link < k; ++link) global_T_base = global_T_base * map.link(link);
      EXPECT_LE(additive_difference(map.global_T_base(k), global_T_base).norm(), 1e-12);
    }
  }
}

TEST(RelativeMap, H2_H3_StackedOrOneByOneIsTheSameWhereTheWorldIsLinear) {
  Rng rng(536);
  const Ring ring(20, 0.001, rng);
  RelativeMap stacked = ring.map();
  RelativeMap singly = stacked;
  for (const auto& [j, starts] : std::vector<std::pair<int, std::vector<int>>>{{11, {0, 1, 2}}, {13, {3}}, {20, {9, 10, 8, 0}}}) {
    std::vector<ObservedLink> observed;
    for (const int i : starts) {
      const Eigen::MatrixXd P = testing::correlated_covariance(rng, Eigen::Vector3d(0.001, 0.001, 0.0001));
      const Eigen::Vector3d error = P.llt().matrixL() * testing::normal_vector(rng, 3);
      observed.push_back({i, {additive_step(stacked.relative(i, j).mean, error), P}});
      singly.observe(j, {observed.back()}, 10);
    }
    stacked.observe(j, observed, 10);
  }
  EXPECT_LE(testing::covariance_difference(stacked.covariance(), singly.covariance()), 0.002);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d difference = additive_difference(stacked.link(k), singly.link(k));
    const Eigen::Vector3d sigma = singly.covariance().diagonal().segment<3>(3 * Eigen::Index{k}).cwiseSqrt();
    EXPECT_LE(difference.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.01);
  }
}

TEST(RelativeMap, NothingObservedChangesNothing) {
  Rng rng(537);
  RelativeMap map = Ring(4, 0.1, rng).map();
  const RelativeMap before = map;
  map.observe(4, {}, 10);
  EXPECT_EQ(map.covariance(), before.covariance());
  EXPECT_EQ(map.link(2).vector(), before.link(2).vector());
}

TEST(RelativeMap, RefusesALoopThatIsNone) {
  Rng rng(534);
  RelativeMap map = Ring(3, 0.1, rng).map();
  EXPECT_THROW(map.observe(1, {{1, {}}}, 1), InvalidArgument);
  EXPECT_THROW(map.observe(4, {{1, {}}}, 1), InvalidArgument);
  EXPECT_THROW(map.observe(2, {{0, {}}, {-1, {}}}, 1), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
