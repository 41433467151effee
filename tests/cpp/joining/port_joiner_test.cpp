#include "ssjs/joining/port_joiner.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/port_estimate.hpp"

namespace ssjs {
namespace {

struct Association {
  int pairs = 0;
  int wrong = 0;
  int surveys_with_wrong = 0;
  double joint = 0.0;  ///< NEES per degree of freedom, mean over surveys
  double rmse_m = 0.0;
};

/// Puts `ghosts` landmarks that nobody else will see into the map: clutter anywhere, or the mirror image of a landmark on the other side.
void add_ghost(LevelledSubmap& map, Eigen::Vector3d position, double sigma_m, std::int64_t id) {
  const Eigen::Index n = map.mean.size();
  map.mean.conservativeResize(n + 3);
  map.mean.tail<3>() = position;
  const Eigen::MatrixXd P = map.covariance;
  map.covariance.setZero(n + 3, n + 3);
  map.covariance.topLeftCorner(n, n) = P;
  map.covariance.bottomRightCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  map.landmarks.push_back({1, id, {id}});
}

Association associate(int seeds, bool with_ghosts, PortSolver solver) {
  Association result;
  for (int seed = 0; seed < seeds; ++seed) {
    Rng rng(500 + static_cast<std::uint64_t>(seed));
    const testing::LevelledWorld world = testing::survey_world(rng);
    PortJoinerConfig config;
    config.solver = solver;
    PortJoiner joiner(config);
    std::int64_t ghost = 1000;
    int wrong = 0;
    for (LevelledSubmap map : testing::survey_maps(world, {}, CompassPorts::kBorders, rng)) {
      if (with_ghosts) {
        const Eigen::Index real = map.landmark_count();
        for (Eigen::Index i = 0; i < real; ++i) {
          if (rng.uniform() > 0.2) continue;  // heard on the other side too
          const Eigen::Vector3d p = map.mean(map.landmark(i));
          add_ghost(map, {p.x(), -p.y(), p.z()}, 0.35, ghost++);
        }
        add_ghost(map, {rng.uniform(0.0, 50.0), rng.uniform(-30.0, 30.0), rng.uniform(15.0, 18.0)}, 0.35, ghost++);
      }
      for (const LoopAttempt& loop : joiner.take(map).loops) {
        result.pairs += loop.pairs;
        wrong += loop.wrong_pairs.value_or(0);
      }
    }
    joiner.finish();
    const testing::BaseErrors errors = testing::base_errors(joiner.level(), world.bases);
    result.joint += errors.joint_per_dof / seeds;
    result.rmse_m += errors.rmse_m / seeds;
    result.wrong += wrong;
    result.surveys_with_wrong += wrong > 0 ? 1 : 0;
  }
  return result;
}

void print(const char* name, const Association& a) {
  std::printf("%s: pairs %d, wrong %d, surveys with wrong %d, joint NEES/dof %.2f, rmse %.2f m\n", name, a.pairs, a.wrong,
              a.surveys_with_wrong, a.joint, a.rmse_m);
}

TEST(PortJoiner, P10_P12_LandmarksAreFoundAgain) {
  const Association clean = associate(4, false, PortSolver::kBatch);
  print("clean", clean);
  EXPECT_GT(clean.pairs, 4 * 35);
  EXPECT_LE(clean.wrong, 2);
  EXPECT_LT(clean.rmse_m, 0.8);
}

TEST(PortJoiner, P12_GhostsAndMirrorImagesFindNoPartner) {
  const Association ghosts = associate(4, true, PortSolver::kRecursive);
  print("ghosts", ghosts);
  EXPECT_GT(ghosts.pairs, 4 * 35);
  EXPECT_LE(ghosts.wrong, 0.02 * ghosts.pairs);
  EXPECT_LT(ghosts.rmse_m, 0.8);
}

TEST(PortJoiner, P10_P12_TwentySurveysWithGhostsLong) {
  for (const bool with_ghosts : {false, true}) {
    const Association result = associate(20, with_ghosts, PortSolver::kBatch);
    print(with_ghosts ? "ghosts" : "clean", result);
    EXPECT_GT(result.pairs, 20 * 35);
    EXPECT_LE(result.wrong, 0.015 * result.pairs);
    EXPECT_LT(result.joint, 1.5);
    EXPECT_LT(result.rmse_m, 0.8);
  }
}

/// Surveys of crossing lines in which no landmark is met again: pairs, all of them wrong.
int pairs_by_chance(int seeds, std::optional<double> max_chance_alignments) {
  int pairs = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Rng rng(900 + static_cast<std::uint64_t>(seed));
    const testing::LevelledWorld world = testing::survey_world(rng);
    PortJoinerConfig config;
    config.max_chance_alignments = max_chance_alignments;
    PortJoiner joiner(config);
    std::int64_t id = 1000;
    for (LevelledSubmap map : testing::survey_maps(world, {}, CompassPorts::kBorders, rng)) {
      const Eigen::Index before = map.landmark_offset(0);
      map.landmarks.clear();
      map.mean.conservativeResize(before);
      map.covariance = Eigen::MatrixXd(map.covariance.topLeftCorner(before, before));
      for (int i = 0; i < 15; ++i) add_ghost(map, {rng.uniform(0.0, 50.0), rng.uniform(-5.0, 5.0), 16.0}, 0.05, id++);
      for (const LoopAttempt& loop : joiner.take(map).loops) pairs += loop.pairs;
    }
  }
  return pairs;
}

TEST(PortJoiner, P41_WhereNothingIsMetAgainChanceAlignsNothing) {
  const int one_by_one = pairs_by_chance(4, std::nullopt);
  const int together = pairs_by_chance(4, 0.001);
  RecordProperty("one_by_one", one_by_one);
  RecordProperty("together", together);
  EXPECT_GT(one_by_one, 10);
  EXPECT_EQ(together, 0);
}

TEST(PortJoiner, MapsThatDoNotFitAreRefused) {
  Rng rng(33);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const std::vector<LevelledSubmap> maps = testing::survey_maps(world, {}, CompassPorts::kBorders, rng);
  PortJoiner joiner{PortJoinerConfig{}};
  EXPECT_THROW(static_cast<void>(joiner.take(maps[1])), InvalidArgument);  // not the next
  LevelledSubmap short_one = maps[0];
  short_one.mean.conservativeResize(short_one.mean.size() - 1);
  EXPECT_THROW(static_cast<void>(joiner.take(short_one)), InvalidArgument);
  static_cast<void>(joiner.take(maps[0]));
  LevelledSubmap other_kind = maps[1];
  other_kind.compass = CompassPorts::kNone;
  EXPECT_THROW(static_cast<void>(joiner.take(other_kind)), InvalidArgument);
  PortJoinerConfig nearest;
  nearest.association = AssociationMethod::kNearestNeighbour;
  EXPECT_THROW(PortJoiner{nearest}, InvalidArgument);
  PortJoinerConfig north;
  north.north_offset_rad = 0.0;
  PortJoiner without_compass(north);
  LevelledSubmap silent = testing::survey_maps(world, {}, CompassPorts::kNone, rng).front();
  EXPECT_THROW(static_cast<void>(without_compass.take(silent)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
