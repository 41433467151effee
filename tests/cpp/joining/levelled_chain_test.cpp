#include "ssjs/joining/levelled_chain.hpp"

#include <gtest/gtest.h>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/batch_ports.hpp"
#include "ssjs/joining/port_association.hpp"

namespace ssjs {
namespace {

constexpr int kFrom = 3;

/// Errors so small that the world is linear: everything else is then exact.
constexpr double kSmall = 1e-4;
testing::MapNoise small_noise() { return {0.15 * kSmall, 0.005 * kSmall, 0.0175 * kSmall, 0.006 * kSmall, 0.35 * kSmall, false}; }

struct Batch {
  std::deque<PortMap> maps;
  BatchPorts level;
};

/// The maps kFrom ... to - 1 as a survey of their own.
void solve(Batch& batch, const std::vector<LevelledSubmap>& all, int to) {
  for (int k = kFrom; k < to; ++k) {
    LevelledSubmap submap = all[static_cast<std::size_t>(k)];
    submap.index = k - kFrom;
    batch.maps.push_back({submap, {}});
    PortMap& map = batch.maps.back();
    std::vector<Port> fresh{{0, {UnknownKind::kBase, submap.index + 1}}};
    const bool constant = submap.compass == CompassPorts::kConstant;
    if (submap.compass_rows() > 0) {
      const Port start{3, {UnknownKind::kOffset, constant ? 0 : submap.index}};
      if (submap.index == 0) {
        fresh.push_back(start);
      } else {
        batch.level.tie(map, {start});
        map.ports.push_back(start);
      }
    }
    if (submap.compass == CompassPorts::kBorders) fresh.push_back({4, {UnknownKind::kOffset, submap.index + 1}});
    batch.level.introduce(map, fresh);
    map.ports.insert(map.ports.end(), fresh.begin(), fresh.end());
  }
  batch.level.settle();
}

TEST(LevelledChain, C1_C2_AChainIsWhatTheBatchSaysOfTheSameMaps) {
  for (const CompassPorts compass : {CompassPorts::kNone, CompassPorts::kConstant, CompassPorts::kBorders}) {
    Rng rng(7);
    const testing::LevelledWorld world = testing::survey_world(rng, 30.0, compass == CompassPorts::kConstant ? 0.0 : 0.0048);
    const std::vector<LevelledSubmap> maps = testing::survey_maps(world, small_noise(), compass, rng);
    LevelledChain chain;
    for (const LevelledSubmap& map : maps) chain.append(map, true, 0.0);
    const LevelledSubmap& first = maps[kFrom];
    ASSERT_GT(first.landmark_count(), 0);
    const Eigen::Index row = first.landmark_offset(0);
    for (const int to : {4, 5, 8, 11, 12, 20, static_cast<int>(maps.size())}) {
      Batch batch;
      solve(batch, maps, to);
      const Unknown last{UnknownKind::kBase, to - kFrom};
      const Stretch way = chain.between(kFrom, to, first, {row, row + 1});
      const Eigen::Vector3d apart = additive_difference(way.first_T_last(), batch.level.values().base(last.index));
      const Eigen::Matrix3d P = batch.level.covariance({last});
      const Eigen::Matrix3d chained = way.covariance.topLeftCorner<3, 3>();
      for (Eigen::Index i = 0; i < 3; ++i) EXPECT_LT(std::abs(apart(i)), 2e-3 * std::sqrt(P(i, i)));
      EXPECT_LT((chained - P).norm(), 2e-3 * P.norm());

      const std::vector<Sighting> seen{{&batch.maps.front(), 0}};
      std::vector<Unknown> unknowns = unknowns_of(seen);
      const PlacedSightings placed = place_sightings(seen, unknowns, batch.level.values());
      unknowns.push_back(last);
      const Eigen::MatrixXd joint = batch.level.covariance(unknowns);
      const Eigen::Index n = joint.rows() - 3;
      const Eigen::MatrixXd J = placed.J.topRows<2>();
      const Eigen::Matrix2d P_landmark = J * joint.topLeftCorner(n, n) * J.transpose() + placed.noise.topLeftCorner<2, 2>();
      const Eigen::Matrix<double, 2, 3> cross = J * joint.topRightCorner(n, 3);
      EXPECT_LT((way.covariance.bottomRightCorner<2, 2>() - P_landmark).norm(), 2e-3 * P_landmark.norm());
      EXPECT_LT((way.covariance.block<2, 3>(way.extra(), 0) - cross).norm(), 2e-3 * std::sqrt(P_landmark.norm() * P.norm()));
    }
  }
}

TEST(LevelledChain, C2_ACompassThatJumpedSaysNothingAcross) {
  Rng rng(8);
  const testing::LevelledWorld world = testing::survey_world(rng, 30.0);
  std::vector<LevelledSubmap> maps = testing::survey_maps(world, {}, CompassPorts::kBorders, rng);
  for (std::size_t k = 5; k < maps.size(); ++k) maps[k].mean.segment<2>(3).array() += 1.0;
  LevelledChain jumped;
  for (const LevelledSubmap& map : maps) jumped.append(map, map.index != 5, 0.0);
  LevelledChain believed;
  for (const LevelledSubmap& map : maps) believed.append(map, true, 0.0);
  const double truth = (world.bases[2].inverse() * world.bases[9]).heading;
  const Stretch way = jumped.between(2, 9, maps[2], {});
  EXPECT_LT(std::abs(angle_difference(way.mean(2), truth)), 4.0 * std::sqrt(way.covariance(2, 2)));
  const Stretch wrong = believed.between(2, 9, maps[2], {});
  EXPECT_LT(wrong.covariance(2, 2), way.covariance(2, 2));
  EXPECT_GT(std::abs(angle_difference(wrong.mean(2), truth)), 6.0 * std::sqrt(wrong.covariance(2, 2)));
  EXPECT_EQ(jumped.between(4, 4, maps[4], {}).covariance.topRows(5).norm(), 0.0);
  EXPECT_THROW(static_cast<void>(jumped.between(4, 3, maps[4], {})), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
