#include "ssjs/joining/port_duplicates.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <memory>
#include <set>

#include "joining/levelled_world.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/batch_ports.hpp"
#include "ssjs/joining/port_estimate.hpp"
#include "ssjs/joining/recursive_ports.hpp"

namespace ssjs {
namespace {

constexpr std::int64_t kAlias = 1000;  // identity under which a landmark is known a second time

void put(PortMap& map, const std::vector<Port>& ports) { map.ports.insert(map.ports.end(), ports.begin(), ports.end()); }

/// Every landmark is an unknown from its first sighting on; sightings of one identity in one map are stacked as they come.
struct ByIdentity {
  std::unique_ptr<PortLevel> level;
  std::deque<PortMap> maps;
  std::map<std::int64_t, int> unknown_of;

  void take(const LevelledSubmap& submap) {
    maps.push_back({submap, {}});
    PortMap& map = maps.back();
    const std::vector<Port> exit{{0, {UnknownKind::kBase, submap.index + 1}}};
    level->introduce(map, exit);
    put(map, exit);
    for (Eigen::Index i = 0; i < submap.landmark_count(); ++i) {
      const std::int64_t id = *submap.landmarks[static_cast<std::size_t>(i)].source_id;
      const auto [known, is_new] = unknown_of.emplace(id, static_cast<int>(unknown_of.size()));
      const std::vector<Port> port{{submap.landmark_offset(i), {UnknownKind::kLandmark, known->second}}};
      if (is_new) {
        level->introduce(map, port);
      } else {
        level->tie(map, port);
      }
      put(map, port);
    }
  }

  /// Those known under a second identity become one with the first.
  int merge_aliases() {
    int merged = 0;
    for (const auto& [id, gone] : unknown_of) {
      const auto first = unknown_of.find(id - kAlias);
      if (first == unknown_of.end()) continue;
      level->merge_landmarks(first->second, gone);
      for (PortMap& map : maps) {
        for (Port& port : map.ports) {
          if (port.unknown == Unknown{UnknownKind::kLandmark, gone}) port.unknown.index = first->second;
        }
      }
      ++merged;
    }
    level->settle();
    return merged;
  }

  /// Bases and landmarks by identity.
  [[nodiscard]] std::vector<Unknown> unknowns(const std::vector<std::int64_t>& ids) const {
    std::vector<Unknown> all;
    for (std::size_t i = 1; i < level->values().bases.size(); ++i) all.push_back({UnknownKind::kBase, static_cast<int>(i)});
    for (const std::int64_t id : ids) all.push_back({UnknownKind::kLandmark, unknown_of.at(id)});
    return all;
  }
};

Eigen::VectorXd stacked(const PortValues& values, const std::vector<Unknown>& unknowns) {
  Eigen::VectorXd y(static_cast<Eigen::Index>(3 * unknowns.size()));
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Unknown& unknown = unknowns[i];
    y.segment<3>(static_cast<Eigen::Index>(3 * i)) =
        unknown.kind == UnknownKind::kBase ? values.base(unknown.index).vector() : values.landmark(unknown.index);
  }
  return y;
}

/// Maps of a survey in which every third map knows each of its landmarks twice.
std::vector<LevelledSubmap> maps_with_doubles(const testing::LevelledWorld& world, const testing::MapNoise& noise, Rng& rng) {
  std::vector<LevelledSubmap> maps;
  for (int k = 0; k + 1 < static_cast<int>(world.bases.size()); ++k) {
    std::vector<int> seen = testing::seen_between(world, k);
    if (k % 3 == 1) {
      const std::vector<int> once = seen;
      seen.insert(seen.end(), once.begin(), once.end());
    }
    const Eigen::MatrixXd P = testing::map_covariance(noise, CompassPorts::kNone, static_cast<Eigen::Index>(seen.size()), rng);
    maps.push_back(testing::noisy_levelled_submap(world, k, seen, CompassPorts::kNone, P, rng));
  }
  return maps;
}

/// The second of two, and landmarks in every other map, go by another identity.
LevelledSubmap with_aliases(LevelledSubmap map) {
  std::set<std::int64_t> met;
  for (MapLandmark& landmark : map.landmarks) {
    const bool again = !met.insert(*landmark.source_id).second;
    if (again || map.index % 3 == 2) *landmark.source_id += kAlias;
  }
  return map;
}

/// Headings are known to 1e-12 rad, positions to 100 m: what is left is linear.
testing::MapNoise linear_noise() { return {100.0, 1e-12, 0.02, 0.01, 100.0, true}; }

TEST(PortDuplicates, P19_MergedLandmarksAreWhatTheyWouldHaveBeenAsOneInALinearWorld) {
  Rng rng(41);
  const testing::LevelledWorld world = testing::survey_world(rng);
  const std::vector<LevelledSubmap> maps = maps_with_doubles(world, linear_noise(), rng);
  ByIdentity once{std::make_unique<BatchPorts>(), {}, {}};
  ByIdentity batch{std::make_unique<BatchPorts>(), {}, {}};
  ByIdentity recursive{std::make_unique<RecursivePorts>(1e9), {}, {}};
  for (const LevelledSubmap& map : maps) {
    once.take(map);
    batch.take(with_aliases(map));
    recursive.take(with_aliases(map));
  }
  once.level->settle();
  EXPECT_GT(batch.merge_aliases(), 15);
  EXPECT_GT(recursive.merge_aliases(), 15);
  std::vector<std::int64_t> shared;
  for (const auto& [id, index] : batch.unknown_of) {
    if (id < kAlias && once.unknown_of.count(id) > 0) shared.push_back(id);
  }
  const std::vector<Unknown> of_once = once.unknowns(shared);
  const Eigen::MatrixXd P = once.level->covariance(of_once);
  const Eigen::ArrayXd sigmas = P.diagonal().array().sqrt().max(1e-5);  // headings differ by rounding only
  for (const ByIdentity* const merged : {&batch, &recursive}) {
    const std::vector<Unknown> unknowns = merged->unknowns(shared);
    const Eigen::VectorXd difference = stacked(merged->level->values(), unknowns) - stacked(once.level->values(), of_once);
    EXPECT_LT((difference.array() / sigmas).abs().maxCoeff<Eigen::PropagateNaN>(), 1e-9);
    EXPECT_LT(testing::covariance_difference(merged->level->covariance(unknowns), P), 1e-9);
  }
}

/// Two entries of one map tied to one unknown: the least-squares solution in which the covariance of every map enters once.
TEST(PortDuplicates, P19_NoMeasurementCountsTwice) {
  Rng rng(42);
  testing::LevelledWorld world = testing::survey_world(rng, 120.0);
  world.bases.resize(6);
  const std::vector<LevelledSubmap> maps = maps_with_doubles(world, {}, rng);
  ByIdentity once{std::make_unique<BatchPorts>(), {}, {}};
  for (const LevelledSubmap& map : maps) once.take(map);
  once.level->settle();
  std::vector<std::int64_t> ids(once.unknown_of.size());
  for (const auto& [id, index] : once.unknown_of) ids[static_cast<std::size_t>(index)] = id;
  const std::vector<Unknown> unknowns = once.unknowns(ids);
  Eigen::Index rows = 0;
  for (const PortMap& map : once.maps) rows += map.submap.mean.size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(rows, rows);
  Eigen::Index at = 0;
  for (const PortMap& map : once.maps) {
    const Eigen::VectorXi of_map = state_rows(map.ports);
    P.block(at, at, of_map.size(), of_map.size()) = map.submap.covariance(of_map, of_map);
    at += of_map.size();
  }
  const auto residual = [&](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    PortValues values = once.level->values();
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      const auto index = static_cast<std::size_t>(unknowns[i].index);
      const Eigen::Vector3d entry = y.segment<3>(static_cast<Eigen::Index>(3 * i));
      if (unknowns[i].kind == UnknownKind::kBase) {
        values.bases[index] = Se2::from_vector(entry);
      } else {
        values.landmarks[index] = entry;
      }
    }
    Eigen::VectorXd r(rows);
    Eigen::Index row = 0;
    for (const PortMap& map : once.maps) {
      const Eigen::VectorXi of_map = state_rows(map.ports);
      r.segment(row, of_map.size()) = port_difference(map.ports, place_ports(map.base(), map.ports, values).s, map.submap.mean(of_map));
      row += of_map.size();
    }
    return r;
  };
  const Eigen::VectorXd y = stacked(once.level->values(), unknowns);
  const testing::BatchSolution oracle = testing::solve_batch(y, residual, P);
  const Eigen::ArrayXd sigmas = oracle.covariance.diagonal().array().sqrt();
  EXPECT_LT(((y - oracle.y).array() / sigmas).abs().maxCoeff<Eigen::PropagateNaN>(), 1e-4);
  EXPECT_LT(testing::covariance_difference(once.level->covariance(unknowns), oracle.covariance), 1e-4);
}

struct Merging {
  int surveys = 0;
  int doubles = 0, merged = 0, wrong = 0;
  int landmarks = 0, objects = 0;  ///< in the world at the end; there in truth and seen
  double joint = 0.0, rmse_m = 0.0;
};

/// Surveys in which a map knows every sixth of its landmarks twice; no identities given.
Merging merge_surveys(int surveys, double duplicate_probability, PortSolver solver) {
  Merging result;
  for (int seed = 0; seed < surveys; ++seed) {
    Rng rng(900 + static_cast<std::uint64_t>(seed));
    const testing::LevelledWorld world = testing::survey_world(rng);
    PortJoinerConfig config;
    config.solver = solver;
    config.duplicate_probability = duplicate_probability;
    PortJoiner joiner(config);
    std::set<int> objects;
    for (int k = 0; k + 1 < static_cast<int>(world.bases.size()); ++k) {
      std::vector<int> seen = testing::seen_between(world, k);
      objects.insert(seen.begin(), seen.end());
      const std::vector<int> once = seen;
      for (const int id : once) {
        if (rng.uniform() > 1.0 / 6.0) continue;
        seen.push_back(id);
        ++result.doubles;
      }
      const Eigen::MatrixXd P = testing::map_covariance({}, CompassPorts::kBorders, static_cast<Eigen::Index>(seen.size()), rng);
      static_cast<void>(joiner.take(testing::noisy_levelled_submap(world, k, seen, CompassPorts::kBorders, P, rng)));
    }
    joiner.finish();
    const testing::BaseErrors errors = testing::base_errors(joiner.level(), world.bases);
    result.joint += errors.joint_per_dof / surveys;
    result.rmse_m += errors.rmse_m / surveys;
    result.merged += joiner.merged();
    result.wrong += joiner.wrongly_merged();
    result.landmarks += static_cast<int>(landmarks_in_world(joiner.maps(), joiner.level()).size());
    result.objects += static_cast<int>(objects.size());
  }
  std::printf("doubles %d, merged %d, wrong %d, landmarks %d of %d objects, joint NEES/dof %.2f, rmse %.2f m\n", result.doubles,
              result.merged, result.wrong, result.landmarks, result.objects, result.joint, result.rmse_m);
  return result;
}

TEST(PortDuplicates, P16_P17_WhatIsKnownTwiceBecomesOne) {
  const Merging apart = merge_surveys(3, 0.0, PortSolver::kBatch);
  const Merging merged = merge_surveys(3, 0.05, PortSolver::kRecursive);
  EXPECT_EQ(apart.merged, 0);
  EXPECT_GT(merged.merged, 0.8 * merged.doubles);
  EXPECT_LE(merged.wrong, 0.05 * merged.merged);
  EXPECT_LT(merged.landmarks - merged.objects, 0.35 * (apart.landmarks - apart.objects));
  EXPECT_LT(merged.rmse_m, 0.8);
}

TEST(PortDuplicates, P16_P19_TwentySurveysLong) {
  const Merging apart = merge_surveys(20, 0.0, PortSolver::kBatch);
  const Merging merged = merge_surveys(20, 0.05, PortSolver::kBatch);
  EXPECT_LE(merged.wrong, 0.03 * merged.merged);
  EXPECT_LT(merged.landmarks - merged.objects, 0.3 * (apart.landmarks - apart.objects));
  EXPECT_GT(merged.joint, 0.85);
  EXPECT_LT(merged.joint, 1.2);
}

/// Two landmarks 0.1 m apart, each known to 0.3 m.
std::size_t landmarks_left(const std::vector<std::vector<double>>& seen_s, double apart_m) {
  LevelledSubmap map;
  map.mean.setZero(9);
  map.mean(0) = 50.0;
  map.mean.segment<3>(3) << 20.0, 10.0, 15.0;
  map.mean.segment<3>(6) << 20.0 + apart_m, 10.0, 15.0;
  map.covariance = 0.09 * Eigen::MatrixXd::Identity(9, 9);
  map.covariance(2, 2) = 1e-4;
  map.landmarks = {{1, std::nullopt, {0}}, {1, std::nullopt, {1}}};
  map.seen_s = seen_s;
  PortJoiner joiner{PortJoinerConfig{}};
  static_cast<void>(joiner.take(map));
  joiner.finish();
  return landmarks_in_world(joiner.maps(), joiner.level()).size();
}

TEST(PortDuplicates, P18_WhatOnePingShowsTwiceIsTwoObjects) {
  EXPECT_EQ(landmarks_left({{10.0}, {400.0}}, 0.1), 1u);
  EXPECT_EQ(landmarks_left({}, 0.1), 1u);
  EXPECT_EQ(landmarks_left({{10.0, 400.0}, {400.0}}, 0.1), 2u);
  EXPECT_EQ(landmarks_left({{10.0}, {400.0}}, 4.0), 2u);
  EXPECT_THROW(static_cast<void>(landmarks_left({{10.0}}, 0.1)), InvalidArgument);
}

}  // namespace
}  // namespace ssjs
