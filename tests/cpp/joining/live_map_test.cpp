#include "ssjs/joining/live_map.hpp"

#include <gtest/gtest.h>

#include <string>

#include "joining/gaussian_world.hpp"
#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using testing::random_map;

constexpr double kRounding = 1e-12;

TEST(LiveMap, J1_ASubmapHasItsExitAsTheOnlyPort) {
  Rng rng(401);
  testing::World world{{{}, {1.0, 2.0, 0.5}, {4.0, 2.0, 0.7}}, Eigen::Matrix2Xd::Random(2, 3)};
  Submap submap = testing::noisy_submap(world, 1, {2, 0}, 0.1, rng);
  submap.landmarks[0].times_seen = 5;
  const LiveMap map = live_map_of(submap);
  EXPECT_EQ(map.base, 1);
  EXPECT_EQ(map.members, std::vector<int>{1});
  EXPECT_EQ(map.poses, std::vector<int>{2});
  EXPECT_EQ(map.ports, 1);
  EXPECT_EQ(map.landmark_count(), 2);
  EXPECT_EQ(map.landmarks[0].times_seen, 5);
  EXPECT_EQ(map.landmarks[1].source_id, 0);
  EXPECT_EQ(map.mean, submap.state.mean);
  EXPECT_EQ(map.landmark_offset(1), 5);
  EXPECT_EQ(map.pose_of(2), 0);
  EXPECT_EQ(map.pose_of(1), std::nullopt);  // its own base is not among its poses
  const Eigen::Vector2d centre = 0.5 * (map.mean.segment<2>(3) + map.mean.segment<2>(5));
  EXPECT_LE((map.centroid - centre).norm(), kRounding);
  EXPECT_NEAR(map.radius, 0.5 * (map.mean.segment<2>(3) - map.mean.segment<2>(5)).norm(), kRounding);
}

TEST(LiveMap, J2_ConditionalFormEqualsTheDenseFormula) {
  Rng rng(402);
  for (const Eigen::Index ports : {1, 2, 3}) {
    const LiveMap map = random_map(rng, 4, {5, 7, 9}, ports, 6, 0.3);
    const Eigen::Index s = 3 * ports;
    const Eigen::Index m = map.mean.size() - s;
    const Eigen::MatrixXd P_ss = map.covariance.topLeftCorner(s, s);
    const Eigen::MatrixXd P_ms = map.covariance.bottomLeftCorner(m, s);
    EXPECT_LE((map.K - P_ms * P_ss.inverse()).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LE((map.conditional_covariance() - (map.covariance.bottomRightCorner(m, m) - P_ms * P_ss.inverse() * P_ms.transpose()))
                  .cwiseAbs()
                  .maxCoeff(),
              kRounding);
    // m - K s is independent of s
    EXPECT_LE((P_ms - map.K * P_ss).cwiseAbs().maxCoeff(), kRounding);
  }
}

TEST(LiveMap, J2_WithoutPortsNothingIsConditioned) {
  Rng rng(403);
  const LiveMap map = random_map(rng, 4, {5}, 0, 2, 0.3);
  EXPECT_EQ(map.K.cols(), 0);
  EXPECT_EQ(map.conditional_covariance(), 0.5 * (map.covariance + map.covariance.transpose()));
}

TEST(LiveMap, SettingPortsMovesThemToTheFrontWithTheirCovariance) {
  Rng rng(404);
  const LiveMap before = random_map(rng, 3, {4, 6, 8}, 3, 2, 0.3);
  LiveMap map = before;
  set_ports(map, {false, true, true});
  EXPECT_EQ(map.poses, (std::vector<int>{6, 8, 4}));
  EXPECT_EQ(map.ports, 2);
  const std::vector<Eigen::Index> order{3, 4, 5, 6, 7, 8, 0, 1, 2, 9, 10, 11, 12};
  for (std::size_t r = 0; r < order.size(); ++r) {
    EXPECT_EQ(map.mean(static_cast<Eigen::Index>(r)), before.mean(order[r]));
    for (std::size_t c = 0; c < order.size(); ++c) {
      EXPECT_EQ(map.covariance(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)), before.covariance(order[r], order[c]));
    }
  }
}

TEST(LiveMap, J2_SingularPortCovarianceNamesTheMap) {
  Rng rng(405);
  LiveMap map = random_map(rng, 12, {13}, 1, 2, 0.3);
  map.covariance.topLeftCorner<3, 3>().setOnes();
  try {
    set_ports(map, {true});
    FAIL() << "a singular port covariance was accepted";
  } catch (const NotPositiveDefinite& error) {
    EXPECT_EQ(std::string(error.what()), "port covariance is not positive definite (map at base 12)");
  }
}

TEST(LiveMap, J2_AVehicleThatHardlyMovedStillGivesAnInvertiblePort) {
  Submap submap;
  submap.state.mean = Eigen::VectorXd::Zero(5);
  submap.state.covariance = Eigen::MatrixXd::Zero(5, 5);
  submap.state.covariance.bottomRightCorner<2, 2>().setIdentity();
  submap.landmarks.resize(1);
  const LiveMap map = live_map_of(submap);
  EXPECT_TRUE(map.K.allFinite());
  EXPECT_LE((map.conditional_covariance() - Eigen::Matrix2d::Identity()).norm(), kRounding);
  submap.state.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)live_map_of(submap), NotPositiveDefinite);
}

}  // namespace
}  // namespace ssjs
