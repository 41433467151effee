#include "ssjs/joining/closure_guard.hpp"

#include <gtest/gtest.h>

#include <cstdio>
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
  double rmse_m = 0.0;
  std::vector<Se2> bases;
};

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
      static_cast<void>(joiner.propose({claims[next].closure}));
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
  for (const bool landmarks : {false, true}) {
    for (const double share : {0.1, 0.3, 0.5}) {
      const Study sum = study(share, 12, landmarks, testing::kWeakNoise);
      if (share < 0.4) {
        EXPECT_LE(sum.guarded_m, 1.2 * sum.clean_m);
      }
    }
  }
}

TEST(ClosureGuard, C9_NothingRefusedNothingChanged) {
  Rng rng(21);
  const testing::LevelledWorld world = testing::weak_world(rng);
  const std::vector<LevelledSubmap> maps = testing::survey_maps(world, testing::kWeakNoise, CompassPorts::kNone, rng);
  const std::vector<Claim> claims = testing::claims(world, 0.0, rng);
  PortJoinerConfig open;
  open.closures.enabled = false;
  const Outcome guarded = run(world, maps, claims, {}, true);
  const Outcome all = run(world, maps, claims, open, true);
  ASSERT_EQ(guarded.true_kept, guarded.claims);
  for (std::size_t i = 0; i < all.bases.size(); ++i) {
    EXPECT_EQ(guarded.bases[i].vector(), all.bases[i].vector());
  }
}

}  // namespace
}  // namespace ssjs
