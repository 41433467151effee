#include <cstdio>
#include <utility>
#include <vector>

#include "../tests/cpp/pipeline/scenario_run.hpp"
#include "bare_ekf.hpp"
#include "cpu_clock.hpp"
#include "quantiles.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

struct MapAnswer {
  Eigen::Matrix2Xd landmarks_m;
  std::vector<std::optional<std::int64_t>> ids;
  std::vector<Eigen::Matrix2d> covariances;
};

class BareRun {
 public:
  BareRun(const SimulatedMission& mission, const SlamConfig& config) : ekf_(config.vehicle.ackerman, mission.world.landmarks_m.cols()) {}

  GaussianSe2 feed(const Event& event) {
    ekf_.feed(event);
    return {{ekf_.x(0), ekf_.x(1), ekf_.x(2)}, ekf_.P.topLeftCorner<3, 3>().selfadjointView<Eigen::Lower>()};
  }
  void finish() {}
  [[nodiscard]] MapAnswer map() const {
    MapAnswer answer;
    answer.landmarks_m.resize(2, (ekf_.size - 3) / 2);
    for (std::size_t id = 0; id < ekf_.row_of.size(); ++id) {
      const Eigen::Index row = ekf_.row_of[id];
      if (row == 0) continue;
      answer.landmarks_m.col(static_cast<Eigen::Index>(answer.ids.size())) = ekf_.x.segment<2>(row);
      answer.covariances.emplace_back(ekf_.P.block<2, 2>(row, row).selfadjointView<Eigen::Lower>());
      answer.ids.emplace_back(static_cast<std::int64_t>(id));
    }
    return answer;
  }
  [[nodiscard]] static double joint_nees_per_dof(const SimulatedMission&) { return std::nan(""); }

 private:
  BareEkf ekf_;
};

class PipelineRun {
 public:
  PipelineRun(const SimulatedMission&, const SlamConfig& config) : pipeline_(config, 0) {}

  GaussianSe2 feed(const Event& event) { return pipeline_.feed(event).global_T_vehicle; }
  void finish() { static_cast<void>(pipeline_.finish()); }
  [[nodiscard]] MapAnswer map() const {
    const WorldEstimate world = pipeline_.world(BaseCovariance::kJoint);
    MapAnswer answer;
    answer.landmarks_m.resize(2, static_cast<Eigen::Index>(world.landmarks.size()));
    for (const LandmarkEstimate& landmark : world.landmarks) {
      answer.landmarks_m.col(static_cast<Eigen::Index>(answer.ids.size())) = landmark.position.mean;
      answer.covariances.push_back(landmark.position.covariance);
      answer.ids.push_back(landmark.landmark.source_id);
    }
    return answer;
  }
  /// Of all submap borders together.
  [[nodiscard]] double joint_nees_per_dof(const SimulatedMission& mission) const {
    const WorldEstimate world = pipeline_.world(BaseCovariance::kJoint);
    const auto bases = static_cast<Eigen::Index>(world.global_T_base.size());
    Eigen::VectorXd error(3 * (bases - 1));
    for (Eigen::Index k = 1; k < bases; ++k) {
      const double end_time_s = pipeline_.submaps()[static_cast<std::size_t>(k - 1)].end_time_s;
      error.segment<3>(3 * (k - 1)) =
          additive_difference(world.global_T_base[static_cast<std::size_t>(k)], testing::truth_at(mission, end_time_s));
    }
    return normalized_squared_error(error, world.base_covariance.bottomRightCorner(error.size(), error.size())) /
           static_cast<double>(error.size());
  }

 private:
  SlamPipeline pipeline_;
};

/// Medians and means are taken over the vectors: one entry a round or a seed.
struct Row {
  const char* method;
  std::vector<double> total_s, feed_s;
  std::vector<double> step_us;  ///< of one mission, each step once
  std::vector<double> map_mean_m, map_aligned_m, landmark_nees, online_mean_m, online_nees, joint_nees_per_dof;
};

template <class Run>
void time_totals(const SimulatedMission& mission, const SlamConfig& config, Row& row) {
  Run run(mission, config);
  const double feed_s = cpu_time_s([&] {
    for (const Event& event : mission.events) static_cast<void>(run.feed(event));
  });
  row.feed_s.push_back(feed_s);
  row.total_s.push_back(feed_s + cpu_time_s([&] { run.finish(); }));
}

template <class Run>
void time_steps(const SimulatedMission& mission, const SlamConfig& config, Row& row) {
  Run run(mission, config);
  for (const Event& event : mission.events) row.step_us.push_back(1e6 * cpu_time_s([&] { static_cast<void>(run.feed(event)); }));
}

template <class Run>
void measure_accuracy(const SimulatedMission& mission, const SlamConfig& config, Row& row) {
  Run run(mission, config);
  std::vector<double> online_m, online_nees;
  for (const Event& event : mission.events) {
    const GaussianSe2 global_T_vehicle = run.feed(event);
    if (!std::holds_alternative<Features>(event.record)) continue;
    const Eigen::Vector3d error = additive_difference(global_T_vehicle.mean, testing::truth_at(mission, event.time_s));
    online_m.push_back(error.head<2>().norm());
    online_nees.push_back(normalized_squared_error(error, global_T_vehicle.covariance));
  }
  run.finish();
  const MapAnswer map = run.map();
  MapErrorConfig map_config;
  map_config.max_distance_m = 1000.0;
  row.map_mean_m.push_back(map_error(map.landmarks_m, map.ids, mission.world.landmarks_m, mission.world.ids, map_config)->mean_m);
  map_config.align = true;
  row.map_aligned_m.push_back(map_error(map.landmarks_m, map.ids, mission.world.landmarks_m, mission.world.ids, map_config)->mean_m);
  std::vector<double> landmark_nees;
  for (Eigen::Index i = 0; i < map.landmarks_m.cols(); ++i) {
    const auto column = static_cast<Eigen::Index>(*map.ids[static_cast<std::size_t>(i)]);  // the scenario numbers its landmarks by column
    landmark_nees.push_back(normalized_squared_error(map.landmarks_m.col(i) - mission.world.landmarks_m.col(column),
                                                     map.covariances[static_cast<std::size_t>(i)]));
  }
  row.landmark_nees.push_back(mean(landmark_nees));
  row.online_mean_m.push_back(mean(online_m));
  row.online_nees.push_back(mean(online_nees));
  row.joint_nees_per_dof.push_back(run.joint_nees_per_dof(mission));
}

std::vector<double> ratios(const std::vector<double>& of, const std::vector<double>& to) {
  std::vector<double> values;
  for (std::size_t i = 0; i < of.size(); ++i) values.push_back(of[i] / to[i]);
  return values;
}

}  // namespace

void study_grid_survey(const StudyOptions& options) {
  Row bare{"bare EKF loop", {}, {}, {}, {}, {}, {}, {}, {}, {}};
  std::vector<std::pair<Method, Row>> methods;
  for (const auto& [method, name] : {std::pair{Method::kEkf, "ekf"},
                                     {Method::kAugmentedEkf, "aekf"},
                                     {Method::kCompressedEkf, "cekf"},
                                     {Method::kConditionallyIndependent, "cis"},
                                     {Method::kSelective, "ssjs"}}) {
    methods.push_back({method, Row{name, {}, {}, {}, {}, {}, {}, {}, {}, {}}});
  }
  const Row& ekf = methods.front().second;
  const Row& ssjs = methods.back().second;
  for (int i = 0; i < std::max(options.rounds, options.seeds); ++i) {
    const auto seed = options.seed + static_cast<std::uint64_t>(i);
    const Scenario scenario = built_in_scenario("grid-survey", seed);
    const SimulatedMission mission = simulate(scenario.world, scenario.config, seed);
    SlamConfig config = testing::matching_config(scenario.config);
    if (i < options.rounds) time_totals<BareRun>(mission, config, bare);
    if (i == 0) time_steps<BareRun>(mission, config, bare);
    if (i < options.seeds) measure_accuracy<BareRun>(mission, config, bare);
    for (auto& [method, row] : methods) {
      config.method = method;
      if (i < options.rounds) time_totals<PipelineRun>(mission, config, row);
      if (i == 0) time_steps<PipelineRun>(mission, config, row);
      if (i < options.seeds) measure_accuracy<PipelineRun>(mission, config, row);
    }
  }
  std::printf("grid-survey, known association, %d rounds (one seed each), accuracy: mean of %d seeds; processor time\n", options.rounds,
              options.seeds);
  std::printf(
      "| method | total s | of it feed s | step p50 us | p99 us | max us | map m | aligned map m | landmark NEES (2) | online m | "
      "online NEES (3) | joint base NEES/dof |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<const Row*> rows{&bare};
  for (const auto& [method, row] : methods) rows.push_back(&row);
  for (const Row* row : rows) {
    std::printf("| %s | %.3f | %.3f | %.1f | %.0f | %.0f | %.3f | %.3f | %.2f | %.2f | %.2f | %.3f |\n", row->method, median(row->total_s),
                median(row->feed_s), quantile(row->step_us, 0.5), quantile(row->step_us, 0.99), largest(row->step_us),
                mean(row->map_mean_m), mean(row->map_aligned_m), mean(row->landmark_nees), mean(row->online_mean_m), mean(row->online_nees),
                mean(row->joint_nees_per_dof));
  }
  const auto print_ratio = [](const char* name, const std::vector<double>& values) {
    std::printf("%s: median %.3f (%.3f to %.3f over the rounds)\n", name, median(values), quantile(values, 0.0), largest(values));
  };
  print_ratio("ssjs / ekf", ratios(ssjs.total_s, ekf.total_s));
  print_ratio("ekf / bare loop", ratios(ekf.total_s, bare.total_s));
}

}  // namespace ssjs::benchmarks
