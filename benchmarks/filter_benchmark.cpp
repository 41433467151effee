// The local filter by the number of landmarks in its state.
#include <benchmark/benchmark.h>

#include <cmath>

#include "ssjs/filter/ekf.hpp"
#include "ssjs/sensors/ackerman.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace {

constexpr int kObservations = 8;  // of one scan, as in scenario S

/// n landmarks around the origin on a spiral that keeps them apart, all correlated through the vehicle.
ssjs::Ekf spiral_map(Eigen::Index n) {
  ssjs::Ekf ekf(n);
  ekf.reset({{0.0, 0.0, 0.0}, 1e-2 * Eigen::Matrix3d::Identity()});
  for (Eigen::Index i = 0; i < n; ++i) {
    const double angle_rad = 0.6 * static_cast<double>(i);
    ssjs::Feature feature;
    feature.range_bearing << 3.0 + 0.05 * static_cast<double>(i), std::remainder(angle_rad, 2.0 * ssjs::kPi);
    feature.covariance = Eigen::Vector2d(1e-2, 3e-4).asDiagonal();
    ekf.add_landmark(feature);
  }
  return ekf;
}

void BM_Predict(benchmark::State& state) {
  ssjs::Ekf ekf = spiral_map(state.range(0));
  const ssjs::AckermanConfig vehicle;
  for (auto _ : state) ekf.predict(predict_ackerman(ekf.vehicle_pose(), {1.0, 0.01}, 1e-6, vehicle));
}
BENCHMARK(BM_Predict)->Arg(15)->Arg(441);

/// One prediction and one stacked update with 8 landmarks.
void BM_PredictAndUpdate(benchmark::State& state) {
  const Eigen::Index n = state.range(0);
  ssjs::Ekf ekf = spiral_map(n);
  const ssjs::MotionPrediction still{{}, Eigen::Matrix3d::Identity(), 1e-6 * Eigen::Matrix3d::Identity()};
  std::vector<ssjs::LinearObservation> observations;
  for (Eigen::Index i = 0; i < kObservations; ++i) {
    const Eigen::Index landmark = i * n / kObservations;
    const ssjs::RangeBearingPrediction h = predict_range_bearing(ekf.vehicle_pose(), ekf.landmark_position(landmark));
    observations.push_back({landmark, Eigen::Vector2d::Zero(), h.H_vehicle, h.H_landmark, Eigen::Vector2d(1e-2, 3e-4).asDiagonal()});
  }
  for (auto _ : state) {
    ekf.predict({ekf.vehicle_pose(), still.F, still.Q});
    benchmark::DoNotOptimize(ekf.update(observations));
  }
}
BENCHMARK(BM_PredictAndUpdate)->Arg(15)->Arg(30)->Arg(60)->Arg(151)->Arg(441)->Arg(1000)->Unit(benchmark::kMicrosecond);

/// P -= Y Y' on the lower triangle: ours against Eigen's rank update, n x n with 16 columns.
void BM_SymmetricDowndate(benchmark::State& state) {
  const Eigen::Index n = state.range(0);
  Eigen::MatrixXd P = 1e3 * Eigen::MatrixXd::Identity((n + 3) / 4 * 4, (n + 3) / 4 * 4);
  const Eigen::MatrixXd Y = 1e-6 * Eigen::MatrixXd::Ones(n, 2 * kObservations);
  ssjs::SymmetricDowndate downdate;
  for (auto _ : state) downdate(Y, P);
}
BENCHMARK(BM_SymmetricDowndate)->Arg(33)->Arg(63)->Arg(305)->Arg(885)->Unit(benchmark::kMicrosecond);

void BM_EigenRankUpdate(benchmark::State& state) {
  const Eigen::Index n = state.range(0);
  Eigen::MatrixXd P = 1e3 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd Y = 1e-6 * Eigen::MatrixXd::Ones(n, 2 * kObservations);
  for (auto _ : state) P.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
}
BENCHMARK(BM_EigenRankUpdate)->Arg(33)->Arg(63)->Arg(305)->Arg(885)->Unit(benchmark::kMicrosecond);

}  // namespace
