#include "ssjs/joining/closure.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "geometry/numeric_jacobian.hpp"
#include "joining/levelled_world.hpp"
#include "ssjs/joining/closure_problem.hpp"

namespace ssjs {
namespace {

const Eigen::Matrix3d kPoseNoise = Eigen::Vector3d(0.04, 0.09, 4e-4).asDiagonal();

struct Survey {
  testing::LevelledWorld world;
  std::deque<PortMap> maps;
  LevelledChain chain;
};

Survey survey_of(Rng& rng, const testing::MapNoise& noise, CompassPorts compass) {
  Survey survey{testing::survey_world(rng, 30.0), {}, {}};
  for (const LevelledSubmap& map : testing::survey_maps(survey.world, noise, compass, rng)) {
    survey.maps.push_back({map, {}});
    survey.chain.append(map, true, 0.0);
  }
  return survey;
}

/// A true relative pose with an error drawn from kPoseNoise.
Closure pose_closure(const Survey& survey, int from, int to, Rng& rng) {
  const Se2 truth = survey.world.bases[static_cast<std::size_t>(from)].inverse() * survey.world.bases[static_cast<std::size_t>(to)];
  const Eigen::Vector3d error = Eigen::LLT<Eigen::Matrix3d>(kPoseNoise).matrixL() * testing::normal_vector(rng, 3);
  return {from, to, GaussianSe2{additive_step(truth, error), kPoseNoise}, {}, "test"};
}

/// All landmarks that two maps share.
std::optional<Closure> pair_closure(const Survey& survey, int from, int to) {
  Closure closure{from, to, {}, {}, "test"};
  const auto& a = survey.maps[static_cast<std::size_t>(from)].submap.landmarks;
  const auto& b = survey.maps[static_cast<std::size_t>(to)].submap.landmarks;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (a[i].source_id == b[j].source_id) closure.pairs.emplace_back(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  if (closure.pairs.empty()) return std::nullopt;
  return closure;
}

std::vector<Closure> all_pair_closures(const Survey& survey) {
  std::vector<Closure> closures;
  const auto n = static_cast<int>(survey.maps.size());
  for (int from = 0; from < n; ++from) {
    for (int to = from + 1; to < n; ++to) {
      if (std::optional<Closure> closure = pair_closure(survey, from, to)) closures.push_back(*closure);
    }
  }
  return closures;
}

TEST(Closure, C4_JacobiansAreThoseOfTheResidual) {
  Rng rng(11);
  const Survey survey = survey_of(rng, {}, CompassPorts::kBorders);
  const std::vector<Closure> pairs = all_pair_closures(survey);
  ASSERT_GT(pairs.size(), 10U);
  for (int point = 0; point < testing::kJacobianPoints; ++point) {
    const auto last = static_cast<int>(survey.maps.size());
    const int from = static_cast<int>(rng.uniform(0.0, last - 4.0));
    const Closure pose = pose_closure(survey, from, from + 1 + static_cast<int>(rng.uniform(0.0, last - from - 1.0)), rng);
    const Closure& pair = pairs[static_cast<std::size_t>(rng.uniform(0.0, static_cast<double>(pairs.size()) - 0.01))];
    const ClosureProblem problem({&pose, &pair}, survey.chain, survey.maps);
    Eigen::VectorXd at = problem.mean();
    for (Eigen::Index i = 0; i < at.size(); ++i) at(i) += rng.normal(0.3);
    const auto of_pose = [&](const Eigen::VectorXd& x) { return problem.residual(0, x).r; };
    const auto of_pair = [&](const Eigen::VectorXd& x) { return problem.residual(1, x).r; };
    EXPECT_TRUE(testing::jacobians_agree(problem.residual(0, at).J, testing::numeric_jacobian(of_pose, at, {2})));
    EXPECT_TRUE(testing::jacobians_agree(problem.residual(1, at).J, testing::numeric_jacobian(of_pair, at)));
  }
}

/// Mean squared distance per degree of freedom of true closures and of true cycles.
struct Calibration {
  double alone = 0.0, given = 0.0;
  int alone_dof = 0, given_dof = 0;
};

void add(Calibration& sum, const CycleFit& cycle) {
  sum.alone += cycle.first.chi_squared;
  sum.alone_dof += cycle.first.dof;
  sum.given += cycle.second_given_first();
  sum.given_dof += cycle.second.dof;
}

Calibration calibrate(CompassPorts compass, const testing::MapNoise& noise, bool poses, int surveys) {
  Calibration sum;
  for (int seed = 0; seed < surveys; ++seed) {
    Rng rng(900 + static_cast<std::uint64_t>(seed));
    const Survey survey = survey_of(rng, noise, compass);
    const std::vector<Closure> pairs = all_pair_closures(survey);
    for (int draw = 0; draw < 6; ++draw) {  // few a survey: those of one survey share their errors
      const auto any = [&] { return static_cast<std::size_t>(rng.uniform(0.0, static_cast<double>(pairs.size()) - 0.01)); };
      Closure a = pairs[any()];
      Closure b = pairs[any()];
      if (a.from == b.from && a.to == b.to) continue;  // for pairs: the very same
      if (poses) a = pose_closure(survey, a.from, a.to, rng);
      if (poses && draw % 2 == 0) b = pose_closure(survey, b.from, b.to, rng);
      if (share_way(a, b)) add(sum, fit_cycle(a, b, survey.chain, survey.maps));
    }
  }
  return sum;
}

/// Means of n squared distances lie within 4 standard deviations sqrt(2 / n) of one; those of one survey are not independent, which the
/// margin of 4 instead of 3 is for.
void expect_calibrated(const char* name, const Calibration& sum) {
  std::printf("%s: alone %.3f (%d dof), given another %.3f (%d dof)\n", name, sum.alone / sum.alone_dof, sum.alone_dof,
              sum.given / sum.given_dof, sum.given_dof);
  EXPECT_NEAR(sum.alone / sum.alone_dof, 1.0, 4.0 * std::sqrt(2.0 / sum.alone_dof));
  EXPECT_NEAR(sum.given / sum.given_dof, 1.0, 4.0 * std::sqrt(2.0 / sum.given_dof));
}

TEST(Closure, C5_C6_TrueCyclesAreAsFarOffAsTheySay) {
  for (const CompassPorts compass : {CompassPorts::kNone, CompassPorts::kBorders}) {
    const char* const name = compass == CompassPorts::kNone ? "no compass" : "compass";
    std::printf("%s, ", name);
    expect_calibrated("pairs", calibrate(compass, {}, false, 150));
    std::printf("%s, ", name);
    expect_calibrated("poses", calibrate(compass, {}, true, 150));
  }
}

TEST(Closure, C6_AnOffsetShowsInTheCycle) {
  Rng rng(12);
  const Survey survey = survey_of(rng, {0.4, 0.02, 0.0175, 0.006, 0.35, false}, CompassPorts::kNone);
  const Closure a = pose_closure(survey, 2, 22, rng);
  Closure b = pose_closure(survey, 3, 21, rng);
  const CycleFit agree = fit_cycle(a, b, survey.chain, survey.maps);
  EXPECT_LT(agree.second_given_first(), 25.0);
  b.from_T_to->mean.x += 20.0;
  const CycleFit apart = fit_cycle(a, b, survey.chain, survey.maps);
  EXPECT_GT(apart.second_given_first(), 5.0 * agree.second_given_first() + 25.0);
  EXPECT_NEAR(apart.off_m, 20.0, 8.0);
  EXPECT_NEAR(apart.second_given_first(), apart.both - apart.first.chi_squared, 1e-12);
  EXPECT_FALSE(share_way(pose_closure(survey, 1, 5, rng), pose_closure(survey, 5, 9, rng)));
  EXPECT_TRUE(share_way(pose_closure(survey, 1, 6, rng), pose_closure(survey, 5, 9, rng)));
}

}  // namespace
}  // namespace ssjs
