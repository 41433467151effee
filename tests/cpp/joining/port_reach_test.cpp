#include "ssjs/joining/port_reach.hpp"

#include <gtest/gtest.h>

#include "joining/levelled_world.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

using namespace ssjs::testing;  // NOLINT(google-build-using-namespace)

/// (J-6) by the joint covariance of every pair of bases.
std::vector<int> by_every_pair(const std::vector<MapExtent>& extents, const PortLevel& level) {
  const auto newest = static_cast<int>(extents.size()) - 1;
  const MapExtent& own = extents.back();
  std::vector<int> others;
  std::vector<Unknown> bases;
  for (int k = 0; k <= newest; ++k) bases.push_back({UnknownKind::kBase, k});
  const Eigen::MatrixXd joint = level.covariance(bases);
  for (int k = 0; k < newest && own.landmarks > 0; ++k) {
    const MapExtent& other = extents[static_cast<std::size_t>(k)];
    if (other.landmarks == 0) continue;
    const RelativePose tau = relative_pose(level.values().base(k), level.values().base(newest));
    Eigen::Matrix<double, 2, 6> J;
    const Eigen::Matrix<double, 2, 3> J_tau = act_jacobian(tau.i_T_j, own.centroid);
    J << J_tau * tau.J_i, J_tau * tau.J_j;
    const Eigen::Index of_k = Eigen::Index{3} * k, of_newest = Eigen::Index{3} * newest;
    const std::vector<Eigen::Index> both{of_k, of_k + 1, of_k + 2, of_newest, of_newest + 1, of_newest + 2};
    const Eigen::Matrix2d P = J * joint(both, both) * J.transpose();
    const double gap_m = (tau.i_T_j * own.centroid - other.centroid).norm() - own.reach_m - other.reach_m;
    if (gap_m <= 3.0 * largest_sigma(P)) others.push_back(k);
  }
  return others;
}

TEST(PortReach, P28_TheBoundLeavesOutNoMapThatIsInReach) {
  Rng rng(311);
  LevelledWorld world;
  world.bases = lawn_mower_bases(6, 240.0, 60.0, 48.0);
  for (std::size_t k = 0; k < world.bases.size(); ++k) world.offsets.push_back(0.7);
  for (int i = 0; i < 150; ++i) world.landmarks.emplace_back(rng.uniform(-30.0, 270.0), rng.uniform(-30.0, 330.0), rng.uniform(15.0, 18.0));
  for (const bool uncertain : {false, true}) {
    MapNoise noise;
    if (uncertain) noise.exit_m = 1.0;
    PortJoinerConfig config;
    config.association = AssociationMethod::kKnown;
    PortJoiner joiner(config);
    PortReach reach;
    std::vector<MapExtent> extents;
    std::size_t in_reach = 0, pairs = 0;
    for (const LevelledSubmap& map : survey_maps(world, noise, CompassPorts::kBorders, rng)) {
      static_cast<void>(joiner.take(map));
      extents.push_back(extent_of(map));
      reach.add(extents.back(), joiner.level());
      const std::vector<int> found = reach.of_newest(joiner.level());
      EXPECT_EQ(found, by_every_pair(extents, joiner.level())) << map.index;
      in_reach += found.size();
      pairs += extents.size() - 1;
    }
    EXPECT_GT(extents.size(), 45U);
    EXPECT_GT(in_reach, extents.size());
    EXPECT_LT(in_reach, pairs / 2);
  }
}

}  // namespace
}  // namespace ssjs
