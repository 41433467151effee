// One fusion by what the older map holds.
#include <benchmark/benchmark.h>

#include "ssjs/joining/fusion.hpp"

namespace {

constexpr int kPairs = 8;
constexpr int kNewLandmarks = 15;

/// Poses and landmarks on a grid with a full covariance. The first pose is the port.
ssjs::LiveMap grid_map(int base, int poses, int landmarks, const Eigen::Vector2d& base_p_first) {
  ssjs::LiveMap map;
  map.base = base;
  map.members = {base};
  const Eigen::Index n = 3 * poses + 2 * landmarks;
  map.mean.resize(n);
  for (int i = 0; i < poses; ++i) {
    map.poses.push_back(base + 1 + i);
    map.mean.segment<3>(3 * i) << 3.0 * (i + 1), 0.1 * i, 0.01 * i;
  }
  map.landmarks.resize(static_cast<std::size_t>(landmarks));
  for (int i = 0; i < landmarks; ++i) map.mean.segment<2>(3 * poses + 2 * i) = base_p_first + Eigen::Vector2d(5.0 * (i % 4), 5.0 * (i / 4));
  map.covariance = 1e-2 * Eigen::MatrixXd::Identity(n, n) + 1e-3 * Eigen::MatrixXd::Ones(n, n);
  std::vector<bool> is_port(static_cast<std::size_t>(poses), false);
  is_port.front() = true;
  set_ports(map, is_port);
  return map;
}

/// A new submap of 15 landmarks against a map of 60 landmarks and the given number of poses; 8 pairs.
void BM_Fuse(benchmark::State& state) {
  const ssjs::LiveMap older = grid_map(0, static_cast<int>(state.range(0)), 60, {1.0, 2.0});
  const ssjs::LiveMap newer = grid_map(5000, 1, kNewLandmarks, {0.0, 0.0});
  std::vector<ssjs::Pair> pairs;
  for (Eigen::Index i = 0; i < kPairs; ++i) pairs.push_back({i, i});
  for (auto _ : state) {
    ssjs::Fusion fusion = fuse(older, newer, pairs);
    std::vector<bool> is_port(fusion.map.poses.size(), false);
    is_port.front() = true;
    set_ports(fusion.map, is_port);
    benchmark::DoNotOptimize(fusion.map.K.data());
  }
}
BENCHMARK(BM_Fuse)->Arg(1)->Arg(10)->Arg(30)->Arg(100)->Arg(300)->Unit(benchmark::kMicrosecond);

}  // namespace
