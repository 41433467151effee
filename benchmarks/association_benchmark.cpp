// Joint compatibility by the number of observations, in a map whose landmarks stand closer than its uncertainty resolves.
#include <benchmark/benchmark.h>

#include "ssjs/association/joint_compatibility.hpp"
#include "ssjs/base/random.hpp"

namespace {

/// A scan of m points and a map of twice as many, 5 m apart, put off by a common displacement within its common uncertainty of 2.5 m.
ssjs::PairingProblem common_displacement(int m) {
  constexpr double kSpacing = 5.0, kCommonSigma = 2.5, kOwnSigma = 0.1;  // m
  const ssjs::Rng rng(3);
  ssjs::Rng place = rng.stream("place");
  ssjs::Rng noise = rng.stream("noise");
  ssjs::PairingProblem problem;
  const int n = 2 * m;
  problem.predicted.resize(2 * n);
  problem.observed.resize(2 * m);
  problem.second_component_is_angle = false;
  for (int i = 0; i < n; ++i) {
    problem.predicted.segment<2>(2 * i) << kSpacing * (i % 5) + place.uniform(-1.0, 1.0), kSpacing * (i / 5) + place.uniform(-1.0, 1.0);
  }
  for (int i = 0; i < m; ++i) {
    problem.observed.segment<2>(2 * i) = problem.predicted.segment<2>(4 * i);
    problem.observed.segment<2>(2 * i) += Eigen::Vector2d(2.6 + noise.normal(kOwnSigma), -1.4 + noise.normal(kOwnSigma));
  }
  problem.observed_covariance = kOwnSigma * kOwnSigma * Eigen::MatrixXd::Identity(2 * m, 2 * m);
  problem.predicted_covariance = kOwnSigma * kOwnSigma * Eigen::MatrixXd::Identity(2 * n, 2 * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      problem.predicted_covariance.block<2, 2>(2 * i, 2 * j) += kCommonSigma * kCommonSigma * Eigen::Matrix2d::Identity();
  }
  return problem;
}

void BM_JointCompatibility(benchmark::State& state) {
  const int m = static_cast<int>(state.range(0));
  const ssjs::PairingProblem problem = common_displacement(m);
  const ssjs::JointCompatibilityConfig config;
  ssjs::Hypothesis hypothesis;
  for (auto _ : state) hypothesis = joint_compatibility(problem, config);
  int right = 0;
  for (const ssjs::Pair& pair : hypothesis.pairs) right += pair.prediction == 2 * pair.observation ? 1 : 0;
  state.counters["right_pairs"] = right;
  state.counters["nodes"] = hypothesis.nodes_visited;
}
BENCHMARK(BM_JointCompatibility)->Arg(4)->Arg(8)->Arg(15)->Arg(30)->Unit(benchmark::kMicrosecond);

}  // namespace
