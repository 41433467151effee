#include "ssjs/joining/closure_guard.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <set>

#include "joining/false_closures.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {
namespace {

using testing::Claim;

struct Outcome {
  int claims = 0, false_claims = 0;
  int true_kept = 0, false_kept = 0;
  int revised = 0;  ///< decisions that were taken back
  double rmse_m = 0.0;
  std::vector<Se2> bases;
};

int revisions(const JoinReport& report) {
  return static_cast<int>(std::count_if(report.loops.begin(), report.loops.end(), [](const LoopAttempt& loop) { return loop.revised; }));
}

/// The maps one by one, each claim as soon as both of its bases are there.
Outcome run(const testing::LevelledWorld& world, const std::vector<LevelledSubmap>& maps, const std::vector<Claim>& claims,
            const PortJoinerConfig& config, bool with_false) {
  PortJoiner joiner(config);
  std::vector<bool> is_false;
  std::size_t next = 0;
  Outcome outcome;
  for (const LevelledSubmap& map : maps) {
    static_cast<void>(joiner.take(map));
    for (; next < claims.size() && claims[next].closure.to <= map.index + 1; ++next) {
      if (claims[next].is_false && !with_false) continue;
      outcome.revised += revisions(joiner.propose({claims[next].closure}));
      outcome.false_claims += claims[next].is_false ? 1 : 0;
      ++outcome.claims;
    }
  }
  joiner.finish();
  // what the level holds at the end: poses of other bases among the ports
  std::set<std::pair<int, Eigen::Index>> held;
  for (const PortMap& map : joiner.maps()) {
    for (const Port& port : map.ports) {
      if (port.unknown.kind == UnknownKind::kBase && port.row > 0) held.insert({map.base(), port.row});
    }
  }
  std::map<int, Eigen::Index> entries;  // poses are appended in the order of the claims
  for (const Claim& claim : claims) {
    if (claim.is_false && !with_false) continue;
    const int from = claim.closure.from;
    const auto at = entries.try_emplace(from, maps[static_cast<std::size_t>(from)].mean.size()).first;
    const bool kept = held.count({from, at->second}) > 0;
    at->second += 3;
    if (kept) ++(claim.is_false ? outcome.false_kept : outcome.true_kept);
  }
  outcome.rmse_m = testing::base_errors(joiner.level(), world.bases).rmse_m;
  outcome.bases = joiner.level().values().bases;
  return outcome;
}

struct Study {
  double clean_m = 0.0, guarded_m = 0.0, open_m = 0.0, alone_m = 0.0, worst_ratio = 0.0;
  int claims = 0, false_claims = 0, true_refused = 0, false_kept = 0;
};

Study study(double share, int seeds, bool landmarks, const testing::MapNoise& noise) {
  Study sum;
  PortJoinerConfig guarded;
  PortJoinerConfig open;
  open.closures.enabled = false;
  for (int seed = 0; seed < seeds; ++seed) {
    Rng rng(4000 + static_cast<std::uint64_t>(seed));
    testing::LevelledWorld world = testing::weak_world(rng);
    if (!landmarks) world.landmarks.clear();
    const std::vector<LevelledSubmap> maps = testing::survey_maps(world, noise, CompassPorts::kNone, rng);
    const std::vector<Claim> claims = testing::claims(world, share, rng);
    const Outcome clean = run(world, maps, claims, open, false);
    const Outcome kept = run(world, maps, claims, guarded, true);
    const Outcome all = run(world, maps, claims, open, true);
    const Outcome none = run(world, maps, {}, open, true);
    sum.clean_m += clean.rmse_m / seeds;
    sum.guarded_m += kept.rmse_m / seeds;
    sum.open_m += all.rmse_m / seeds;
    sum.alone_m += none.rmse_m / seeds;
    sum.worst_ratio = std::max(sum.worst_ratio, kept.rmse_m / clean.rmse_m);
    sum.claims += kept.claims;
    sum.false_claims += kept.false_claims;
    sum.true_refused += kept.claims - kept.false_claims - kept.true_kept;
    sum.false_kept += kept.false_kept;
    std::printf("  seed %d: clean %.2f guarded %.2f without %.2f no closures %.2f; false kept %d of %d, true refused %d of %d\n", seed,
                clean.rmse_m, kept.rmse_m, all.rmse_m, none.rmse_m, kept.false_kept, kept.false_claims,
                kept.claims - kept.false_claims - kept.true_kept, kept.claims - kept.false_claims);
  }
  std::printf("| %.0f %% | %d | %d | %d | %d | %.2f | %.2f | %.2f | %.2f | %.2f |\n", 100.0 * share, sum.claims, sum.false_claims,
              sum.false_claims - sum.false_kept, sum.true_refused, sum.clean_m, sum.guarded_m, sum.worst_ratio, sum.open_m, sum.alone_m);
  return sum;
}

TEST(ClosureGuard, C6_C9_AThirdOfFalseClosuresCostsLittle) {
  const Study sum = study(0.3, 4, false, testing::kWeakNoise);
  EXPECT_LE(sum.guarded_m, 1.2 * sum.clean_m);
  EXPECT_GT(sum.open_m, 2.0 * sum.clean_m);  // what they would have done
  EXPECT_LE(sum.true_refused, 0.05 * (sum.claims - sum.false_claims));
}

TEST(ClosureGuard, C6_C9_TwelveSurveysLong) {
  for (const double share : {0.1, 0.3, 0.5}) {
    const Study sum = study(share, 12, false, testing::kWeakNoise);
    EXPECT_LE(sum.guarded_m, 1.2 * sum.clean_m);
    EXPECT_GT(sum.open_m, 2.0 * sum.clean_m);
  }
  static_cast<void>(study(0.3, 12, false, {0.8, 0.04, 0.0175, 0.006, 0.35, false}));  // twice as weak
  static_cast<void>(study(0.3, 12, true, testing::kWeakNoise));
}

/// Lines of 150 m, a map every 15 m, claims all over: what a closure costs among a thousand maps (processor time).
TEST(ClosureGuard, C8_AThousandMapsLong) {
  Rng rng(77);
  testing::LevelledWorld world = testing::weak_world(rng);
  world.landmarks.clear();
  world.bases = testing::lawn_mower_bases(60, 230.0, 10.0, 15.0);
  world.offsets.assign(world.bases.size(), 0.0);
  const std::vector<LevelledSubmap> maps = testing::survey_maps(world, {0.1, 0.004, 0.0175, 0.006, 0.35, false}, CompassPorts::kNone, rng);
  const std::vector<Claim> claims = testing::claims(world, 0.3, rng);
  const auto begin = std::clock();
  const Outcome guarded = run(world, maps, claims, {}, true);
  const auto middle = std::clock();
  PortJoinerConfig open;
  open.closures.enabled = false;
  const Outcome all = run(world, maps, claims, open, true);
  const auto end = std::clock();
  const auto seconds = [](std::clock_t ticks) { return static_cast<double>(ticks) / CLOCKS_PER_SEC; };
  std::printf(
      "%zu maps, %d claims (%d false): with guard %.1f s, without %.1f s of processor time; false kept %d, true refused %d, %d revisions; "
      "error %.2f m, without guard %.2f m\n",
      maps.size(), guarded.claims, guarded.false_claims, seconds(middle - begin), seconds(end - middle), guarded.false_kept,
      guarded.claims - guarded.false_claims - guarded.true_kept, guarded.revised, guarded.rmse_m, all.rmse_m);
  EXPECT_LE(guarded.false_kept, guarded.false_claims / 20);
}

TEST(ClosureGuard, C9_NothingRefusedNothingChanged) {
  Rng rng(21);
  testing::LevelledWorld world = testing::weak_world(rng);
  world.landmarks.resize(40);
  const std::vector<LevelledSubmap> maps = testing::survey_maps(world, testing::kWeakNoise, CompassPorts::kNone, rng);
  const std::vector<Claim> claims = testing::claims(world, 0.0, rng);
  PortJoinerConfig open;
  open.closures.enabled = false;
  const Outcome guarded = run(world, maps, claims, {}, true);
  const Outcome all = run(world, maps, claims, open, true);
  ASSERT_EQ(guarded.true_kept, guarded.claims);
  for (std::size_t i = 0; i < all.bases.size(); ++i) EXPECT_EQ(guarded.bases[i].vector(), all.bases[i].vector());
}

/// One false claim that comes first and is believed for want of witnesses, then true ones.
struct LateDoubt {
  testing::LevelledWorld world;
  std::vector<LevelledSubmap> maps;
  std::vector<Claim> claims;
};

LateDoubt late_doubt(int landmarks) {
  Rng rng(31);
  LateDoubt doubt{testing::weak_world(rng), {}, {}};
  doubt.world.landmarks.resize(static_cast<std::size_t>(landmarks));
  doubt.maps = testing::survey_maps(doubt.world, testing::kWeakNoise, CompassPorts::kNone, rng);
  doubt.claims.push_back(testing::claim(doubt.world, 1, 26, {4.0, 3.0}, rng));
  for (const int to : {26, 27, 28, 29}) doubt.claims.push_back(testing::claim(doubt.world, to - 25, to, Eigen::Vector2d::Zero(), rng));
  return doubt;
}

TEST(ClosureGuard, C9_C11_AnEarlyMistakeIsTakenBackAndLeavesNothing) {
  for (const PortSolver solver : {PortSolver::kBatch, PortSolver::kRecursive}) {
    const LateDoubt doubt = late_doubt(0);
    PortJoinerConfig config;
    config.solver = solver;
    PortJoiner joiner(config);
    PortJoiner never(config);
    for (const LevelledSubmap& map : doubt.maps) {
      static_cast<void>(joiner.take(map));
      static_cast<void>(never.take(map));
    }
    const JoinReport first = joiner.propose({doubt.claims.front().closure});
    ASSERT_EQ(first.loops.size(), 1U);
    EXPECT_TRUE(first.loops.front().accepted);
    bool taken_back = false;
    for (std::size_t i = 1; i < doubt.claims.size(); ++i) {
      for (const LoopAttempt& loop : joiner.propose({doubt.claims[i].closure}).loops) {
        if (!loop.revised) continue;
        taken_back = !loop.accepted;
        EXPECT_NE(loop.reason.find("contradicts"), std::string::npos) << loop.reason;
        EXPECT_NE(loop.reason.find("dof"), std::string::npos) << loop.reason;
        std::printf("%s\n", loop.reason.c_str());
      }
      static_cast<void>(never.propose({doubt.claims[i].closure}));
    }
    EXPECT_TRUE(taken_back);
    joiner.finish();
    never.finish();
    for (std::size_t i = 0; i < doubt.world.bases.size(); ++i) {
      const Eigen::Vector3d apart = additive_difference(joiner.level().values().bases[i], never.level().values().bases[i]);
      EXPECT_LT(apart.norm(), 1e-6);
    }
  }
}

/// Two landmarks of two maps that are not one, said to be; those nearest to each other first, 4 m apart or more.
std::vector<Closure> wrong_pairs(const LateDoubt& doubt) {
  std::vector<std::pair<double, Closure>> wrong;
  for (int to = 8; to < 40; ++to) {
    for (int from = 1; from + 5 < to; ++from) {
      const auto& a = doubt.maps[static_cast<std::size_t>(from)].landmarks;
      const auto& b = doubt.maps[static_cast<std::size_t>(to)].landmarks;
      for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t j = 0; j < b.size(); ++j) {
          const Eigen::Vector3d apart = doubt.world.landmarks[static_cast<std::size_t>(*a[i].source_id)] -
                                        doubt.world.landmarks[static_cast<std::size_t>(*b[j].source_id)];
          if (apart.head<2>().norm() < 4.0) continue;
          const Closure closure{from, to, {}, {{static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)}}, "test"};
          wrong.emplace_back(apart.head<2>().norm(), closure);
        }
      }
    }
  }
  std::stable_sort(wrong.begin(), wrong.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Closure> closures;
  for (const auto& [apart_m, closure] : wrong) closures.push_back(closure);
  return closures;
}

TEST(ClosureGuard, C6_AWrongPairOfLandmarksIsRefused) {
  const LateDoubt doubt = late_doubt(40);
  PortJoiner joiner{PortJoinerConfig{}};
  for (const LevelledSubmap& map : doubt.maps) static_cast<void>(joiner.take(map));
  const auto ports_before = joiner.level().values().landmarks.size();
  const JoinReport report = joiner.propose({wrong_pairs(doubt).front()});
  ASSERT_FALSE(report.loops.empty());
  EXPECT_FALSE(report.loops.front().accepted);
  EXPECT_NE(report.loops.front().reason.find("contradicts"), std::string::npos) << report.loops.front().reason;
  EXPECT_EQ(joiner.level().values().landmarks.size(), ports_before);
}

TEST(ClosureGuard, C11_LandmarksMergedByMistakeComeApart) {
  const LateDoubt doubt = late_doubt(40);
  PortJoinerConfig config;
  config.association = AssociationMethod::kKnown;  // and no identities: nothing is found by the joiner itself
  std::vector<LevelledSubmap> nameless = doubt.maps;
  for (LevelledSubmap& map : nameless) {
    for (MapLandmark& landmark : map.landmarks) landmark.source_id.reset();
  }
  Rng rng(32);
  int merged = 0;
  int apart_again = 0;
  for (const Closure& wrong : wrong_pairs(doubt)) {
    if (merged == 3) break;
    PortJoiner joiner(config);
    PortJoiner never(config);
    for (const LevelledSubmap& map : nameless) {
      static_cast<void>(joiner.take(map));
      static_cast<void>(never.take(map));
    }
    if (!joiner.propose({wrong}).loops.front().accepted) continue;  // against the way
    ++merged;
    ASSERT_EQ(joiner.level().values().landmarks.size(), 1U);
    for (int i = -1; i <= 1; ++i) {
      const Closure truth = testing::claim(doubt.world, wrong.from + i, wrong.to + i, Eigen::Vector2d::Zero(), rng).closure;
      for (PortJoiner* const one : {&joiner, &never}) static_cast<void>(one->propose({truth}));
    }
    joiner.finish();
    never.finish();
    if (!joiner.level().values().landmarks.empty()) continue;
    ++apart_again;
    for (std::size_t i = 0; i < doubt.world.bases.size(); ++i) {
      const Eigen::Vector3d apart = additive_difference(joiner.level().values().bases[i], never.level().values().bases[i]);
      EXPECT_LT(apart.norm(), 1e-6);
    }
  }
  std::printf("merged by mistake %d, apart again %d\n", merged, apart_again);
  EXPECT_EQ(merged, 3);
  EXPECT_EQ(apart_again, merged);
}

TEST(ClosureGuard, C4_PairsOfLandmarksHandedInAreTied) {
  const LateDoubt doubt = late_doubt(60);
  PortJoinerConfig config;
  config.association = AssociationMethod::kKnown;
  PortJoiner by_identity(config);
  std::vector<LevelledSubmap> nameless = doubt.maps;
  for (LevelledSubmap& map : nameless) {
    for (MapLandmark& landmark : map.landmarks) landmark.source_id.reset();
  }
  PortJoiner handed(config);  // finds nothing by itself
  std::map<std::int64_t, std::pair<int, Eigen::Index>> first;
  int pairs = 0;
  for (std::size_t k = 0; k < nameless.size(); ++k) {
    static_cast<void>(by_identity.take(doubt.maps[k]));
    static_cast<void>(handed.take(nameless[k]));
    std::map<int, Closure> closures;
    for (std::size_t i = 0; i < doubt.maps[k].landmarks.size(); ++i) {
      const auto entry = static_cast<Eigen::Index>(i);
      const auto [known, is_new] = first.try_emplace(*doubt.maps[k].landmarks[i].source_id, static_cast<int>(k), entry);
      if (is_new) continue;
      Closure& closure = closures[known->second.first];
      closure.from = known->second.first;
      closure.to = static_cast<int>(k);
      closure.pairs.emplace_back(known->second.second, entry);
      ++pairs;
    }
    for (const auto& [from, closure] : closures) {
      for (const LoopAttempt& loop : handed.propose({closure}).loops) EXPECT_TRUE(loop.accepted) << loop.reason;
    }
  }
  ASSERT_GT(pairs, 30);
  by_identity.finish();
  handed.finish();
  for (std::size_t i = 0; i < doubt.world.bases.size(); ++i) {
    const Eigen::Vector3d apart = additive_difference(by_identity.level().values().bases[i], handed.level().values().bases[i]);
    EXPECT_LT(apart.norm(), 1e-6);
  }
}

TEST(ClosureGuard, ARestoredJoinerDecidesAsTheOneThatWentOn) {
  const LateDoubt doubt = late_doubt(40);
  PortJoiner joiner{PortJoinerConfig{}};
  PortJoiner restored{PortJoinerConfig{}};
  const std::size_t half = 30;
  for (std::size_t k = 0; k < half; ++k) static_cast<void>(joiner.take(doubt.maps[k]));
  for (std::size_t i = 0; i < 3; ++i) static_cast<void>(joiner.propose({doubt.claims[i].closure}));
  Archive out;
  joiner.archive(out);
  const std::string bytes = out.take_bytes();
  Archive in(bytes, "joiner");
  restored.archive(in);
  in.end();
  for (PortJoiner* const one : {&joiner, &restored}) {
    for (std::size_t i = 3; i < doubt.claims.size(); ++i) static_cast<void>(one->propose({doubt.claims[i].closure}));
    for (std::size_t k = half; k < doubt.maps.size(); ++k) static_cast<void>(one->take(doubt.maps[k]));
    one->finish();
  }
  Archive a;
  Archive b;
  joiner.archive(a);
  restored.archive(b);
  EXPECT_EQ(a.take_bytes(), b.take_bytes());
}

TEST(ClosureGuard, WhatIsNoClosureIsRefused) {
  const LateDoubt doubt = late_doubt(40);
  PortJoiner joiner{PortJoinerConfig{}};
  EXPECT_THROW(static_cast<void>(joiner.propose({doubt.claims.front().closure})), InvalidArgument);  // no such maps yet
  for (std::size_t k = 0; k < 10; ++k) static_cast<void>(joiner.take(doubt.maps[k]));
  const GaussianSe2 pose{{1.0, 2.0, 0.1}, testing::kClaimNoise};
  EXPECT_THROW(static_cast<void>(joiner.propose({{3, 11, pose, {}, ""}})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(joiner.propose({{3, 3, pose, {}, ""}})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(joiner.propose({{3, 8, {}, {}, ""}})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(joiner.propose({{3, 8, {}, {{99, 0}}, ""}})), InvalidArgument);
  EXPECT_THROW(static_cast<void>(joiner.propose({{3, 8, GaussianSe2{{}, Eigen::Matrix3d::Zero()}, {}, ""}})), NotPositiveDefinite);
  EXPECT_NO_THROW(static_cast<void>(joiner.propose({{3, 10, GaussianSe2{{}, 1e6 * Eigen::Matrix3d::Identity()}, {}, ""}})));
}

}  // namespace
}  // namespace ssjs
