#include <cstdio>
#include <fstream>
#include <map>

#include "../tests/cpp/pipeline/scenario_run.hpp"
#include "cpu_clock.hpp"
#include "quantiles.hpp"
#include "ssjs/base/error.hpp"
#include "ssjs/joining/selective.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

constexpr int kDeciles = 10;

/// One finished submap at the global level.
struct Closing {
  double time_s = 0.0;
  double global_ms = 0.0;  ///< SelectiveJoiner::take and the pose of the new base, processor time
  int candidates = 0, fusions = 0;
  int live_bases = 0, live_maps = 0;
  int largest_map_states = 0;  ///< of any live map: 3 a pose, 2 a landmark
  bool is_sparse = false;
};

struct LocalStep {
  double time_s;
  double cpu_us;
};

/// The local layer's share of a mission.
struct LocalMission {
  std::vector<LocalStep> steps;  ///< those that close no submap
  std::vector<Submap> submaps;
  double total_s = 0.0;
};

SlamConfig scaling_config(const VehicleSimulationConfig& simulation, const StudyOptions& options) {
  SlamConfig config = testing::matching_config(simulation);
  if (options.association == "jcbb") {
    config.association.method = AssociationMethod::kJointCompatibility;
    config.joining.max_pairing_sigma_m = 1.5;  // 0.3 of the landmark spacing
  }
  return config;
}

/// Local maps do not depend on the joining layer: here it compares nothing.
LocalMission build_submaps(const SimulatedMission& mission, SlamConfig config) {
  config.joining.min_pairs = 1000000;
  config.joining.final_adjustment = false;
  LocalMission local;
  SlamPipeline pipeline(config, 0);
  for (const Event& event : mission.events) {
    StepReport step;
    const double cpu_s = cpu_time_s([&] { step = pipeline.feed(event); });
    local.total_s += cpu_s - step.global_time_s - (step.join ? step.join->association_time_s : 0.0);  // without the joining layer
    if (!step.join) local.steps.push_back({event.time_s, 1e6 * cpu_s});
  }
  local.total_s += cpu_time_s([&] { static_cast<void>(pipeline.finish()); });
  local.submaps = pipeline.submaps();
  return local;
}

int largest_map_states(const SelectiveJoiner& joiner) {
  Eigen::Index largest = 0;
  for (const auto& [base, map] : joiner.maps()) largest = std::max(largest, map.mean.size());
  return static_cast<int>(largest);
}

/// The joining layer sees finished submaps only, so that it can be timed alone.
class Joining {
 public:
  explicit Joining(const SlamConfig& config) : joiner_(config.joining, config.association.method, config.submap.split.max_landmarks, 0) {}

  Closing take(const Submap& submap) {
    Closing closing;
    JoinReport report;
    closing.global_ms = 1e3 * cpu_time_s([&] {
                          report = joiner_.take(submap);
                          static_cast<void>(joiner_.global_T_newest_base());
                        });
    closing.time_s = submap.end_time_s;
    closing.candidates = report.candidates;
    for (const LoopAttempt& loop : report.loops) closing.fusions += loop.accepted ? 1 : 0;
    closing.live_bases = static_cast<int>(joiner_.global().bases().size());
    closing.live_maps = static_cast<int>(joiner_.maps().size());
    closing.largest_map_states = largest_map_states(joiner_);
    closing.is_sparse = joiner_.global().is_sparse();
    return closing;
  }

  SelectiveJoiner& joiner() { return joiner_; }

 private:
  SelectiveJoiner joiner_;
};

void write_csv(const std::string& path, const std::vector<Closing>& closings) {
  if (path.empty()) return;
  std::ofstream file(path);
  file << "time_s,global_ms,candidates,fusions,live_bases,live_maps,largest_map_states,is_sparse\n";
  for (const Closing& c : closings) {
    file << c.time_s << ',' << c.global_ms << ',' << c.candidates << ',' << c.fusions << ',' << c.live_bases << ',' << c.live_maps << ','
         << c.largest_map_states << ',' << (c.is_sparse ? 1 : 0) << '\n';
  }
  if (!file) throw FileError(path, 0, "cannot be written; name a file in an existing directory");
}

void print_deciles(const std::vector<Closing>& closings, const std::vector<LocalStep>& steps) {
  std::printf(
      "| decile of the mission | closings | live bases | live maps | largest map, states | candidates a closing | fusions a closing | "
      "global p50 ms | p99 ms | max ms | local step p50 us | p99 us |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  const double end_s = steps.back().time_s;
  for (int decile = 0; decile < kDeciles; ++decile) {
    const double from_s = end_s * decile / kDeciles;
    const double to_s = decile + 1 == kDeciles ? end_s * 1.001 : end_s * (decile + 1) / kDeciles;
    std::vector<double> global_ms, local_us, candidates, fusions;
    const Closing* last = nullptr;
    for (const Closing& closing : closings) {
      if (closing.time_s < from_s || closing.time_s >= to_s) continue;
      global_ms.push_back(closing.global_ms);
      candidates.push_back(closing.candidates);
      fusions.push_back(closing.fusions);
      last = &closing;
    }
    for (const LocalStep& step : steps) {
      if (step.time_s >= from_s && step.time_s < to_s) local_us.push_back(step.cpu_us);
    }
    if (last == nullptr) continue;
    std::printf("| %d | %zu | %d%s | %d | %d | %.2f | %.2f | %.3f | %.3f | %.3f | %.2f | %.1f |\n", decile + 1, global_ms.size(),
                last->live_bases, last->is_sparse ? " sparse" : "", last->live_maps, last->largest_map_states, mean(candidates),
                mean(fusions), median(global_ms), quantile(global_ms, 0.99), largest(global_ms), median(local_us),
                quantile(local_us, 0.99));
  }
}

/// All closings of a mission, and what came out.
struct GlobalMission {
  std::vector<Closing> closings;
  double total_s = 0.0, finish_s = 0.0, estimate_s = 0.0;
  double memory_joined_mb = 0.0, memory_estimated_mb = 0.0;
  std::vector<double> online_m, online_nees;
  double map_mean_m = 0.0, map_aligned_m = 0.0, landmark_nees = 0.0, base_nees = 0.0;
};

void measure_map(const WorldEstimate& world, const SimulatedMission& mission, GlobalMission& result) {
  Eigen::Matrix2Xd landmarks_m(2, static_cast<Eigen::Index>(world.landmarks.size()));
  std::vector<std::optional<std::int64_t>> ids;
  std::vector<double> nees;
  for (const LandmarkEstimate& landmark : world.landmarks) {
    const auto column = static_cast<Eigen::Index>(*landmark.landmark.source_id);  // the worlds number their landmarks by column
    landmarks_m.col(static_cast<Eigen::Index>(ids.size())) = landmark.position.mean;
    ids.push_back(landmark.landmark.source_id);
    nees.push_back(normalized_squared_error(landmark.position.mean - mission.world.landmarks_m.col(column), landmark.position.covariance));
  }
  MapErrorConfig config;
  config.max_distance_m = 1000.0;
  result.map_mean_m = map_error(landmarks_m, ids, mission.world.landmarks_m, mission.world.ids, config)->mean_m;
  config.align = true;
  result.map_aligned_m = map_error(landmarks_m, ids, mission.world.landmarks_m, mission.world.ids, config)->mean_m;
  result.landmark_nees = mean(nees);
}

/// The joint estimate of all bases takes long in a large mission and is the same in every round: `with_map` asks for it.
GlobalMission join_all(const std::vector<Submap>& submaps, const SimulatedMission& mission, const SlamConfig& config, bool with_map) {
  GlobalMission result;
  Joining joining(config);
  for (const Submap& submap : submaps) {
    result.closings.push_back(joining.take(submap));
    result.total_s += 1e-3 * result.closings.back().global_ms;
    const GaussianSe2 global_T_base = joining.joiner().global_T_newest_base();
    const Eigen::Vector3d error = additive_difference(global_T_base.mean, testing::truth_at(mission, submap.end_time_s));
    result.online_m.push_back(error.head<2>().norm());
    result.online_nees.push_back(normalized_squared_error(error, global_T_base.covariance));
  }
  result.memory_joined_mb = peak_memory_mb();
  if (!with_map) return result;
  result.finish_s = cpu_time_s([&] { joining.joiner().finish(); });
  WorldEstimate world;
  result.estimate_s = cpu_time_s([&] { world = joining.joiner().estimate(BaseCovariance::kBorders); });
  result.memory_estimated_mb = peak_memory_mb();
  measure_map(world, mission, result);
  std::vector<double> base_nees;
  for (const Submap& submap : submaps) {
    const auto k = static_cast<std::size_t>(submap.index);
    const Eigen::Vector3d error = additive_difference(world.global_T_base[k + 1], testing::truth_at(mission, submap.end_time_s));
    base_nees.push_back(normalized_squared_error(error, world.border_covariance[k].bottomRightCorner<3, 3>()));
  }
  result.base_nees = mean(base_nees);
  return result;
}

/// The median over the rounds of every closing's time; everything else is the same in every round.
void set_median_times(std::vector<GlobalMission>& rounds) {
  for (std::size_t i = 0; i < rounds.front().closings.size(); ++i) {
    std::vector<double> times_ms;
    for (const GlobalMission& round : rounds) times_ms.push_back(round.closings[i].global_ms);
    rounds.front().closings[i].global_ms = median(times_ms);
  }
}

void study_scaling(const char* name, const SimulatedMission& mission, const SlamConfig& config, const StudyOptions& options) {
  const double memory_before_mb = peak_memory_mb();
  const LocalMission local = build_submaps(mission, config);
  const double memory_local_mb = peak_memory_mb();
  std::vector<GlobalMission> rounds;
  for (int round = 0; round < options.rounds; ++round) rounds.push_back(join_all(local.submaps, mission, config, round == 0));
  set_median_times(rounds);
  const GlobalMission& global = rounds.front();

  std::vector<double> local_us, global_ms;
  for (const LocalStep& step : local.steps) local_us.push_back(step.cpu_us);
  for (const Closing& closing : global.closings) global_ms.push_back(closing.global_ms);
  const double mission_s = mission.events.back().time_s;
  const double total_s = local.total_s + global.total_s + global.finish_s + global.estimate_s;
  std::printf("%s: %td landmarks, %zu events, %zu submaps, association %s, global level: median of %d rounds; processor time\n", name,
              static_cast<std::ptrdiff_t>(mission.world.landmarks_m.cols()), mission.events.size(), local.submaps.size(),
              options.association.c_str(), options.rounds);
  std::printf("local %.2f s, closings %.2f s, finish %.2f s, estimate of everything %.2f s; mission %.0f s: %.0f x real time\n",
              local.total_s, global.total_s, global.finish_s, global.estimate_s, mission_s, mission_s / total_s);
  std::printf("local steps: p50 %.2f us, p99 %.1f us, max %.0f us\n", median(local_us), quantile(local_us, 0.99), largest(local_us));
  std::printf("global level per closing: p50 %.3f ms, p99 %.3f ms, max %.3f ms\n", median(global_ms), quantile(global_ms, 0.99),
              largest(global_ms));
  std::printf("peak memory: simulated log %.0f MB, submaps built %.0f MB, all joined %.0f MB, joint estimate of all bases %.0f MB\n",
              memory_before_mb, memory_local_mb, global.memory_joined_mb, global.memory_estimated_mb);
  std::printf(
      "online at the closings: mean %.2f m, max %.2f m, NEES (3) mean %.2f; final map: mean %.3f m, aligned %.3f m, "
      "landmark NEES (2) %.2f, base NEES (3) %.2f\n",
      mean(global.online_m), largest(global.online_m), mean(global.online_nees), global.map_mean_m, global.map_aligned_m,
      global.landmark_nees, global.base_nees);
  print_deciles(global.closings, local.steps);
  write_csv(options.csv, global.closings);
}

}  // namespace

void study_revisit(const StudyOptions& options) {
  const VehicleSimulationConfig simulation = large_world_config();
  const SimulatedMission mission = simulate(revisit_world(20, 20, 5.0, 1.0, options.laps, options.seed), simulation, options.seed);
  study_scaling("revisit", mission, scaling_config(simulation, options), options);
}

void study_exploration(const StudyOptions& options) {
  const VehicleSimulationConfig simulation = large_world_config();
  const World world = exploration_world(options.columns, options.rows, 5.0, 1.0, 10.0, options.seed);
  study_scaling("exploration", simulate(world, simulation, options.seed), scaling_config(simulation, options), options);
}

void study_crossover(const StudyOptions& options) {
  const VehicleSimulationConfig simulation = large_world_config();
  const World world = exploration_world(options.columns, options.rows, 5.0, 1.0, 10.0, options.seed);
  const SimulatedMission mission = simulate(world, simulation, options.seed);
  SlamConfig dense = scaling_config(simulation, options);
  dense.joining.dense_bases = 1000000;
  SlamConfig sparse = dense;
  sparse.joining.solver = GlobalSolver::kGaussNewton;
  const LocalMission local = build_submaps(mission, dense);
  std::vector<GlobalMission> dense_rounds, sparse_rounds;
  for (int round = 0; round < options.rounds; ++round) {
    dense_rounds.push_back(join_all(local.submaps, mission, dense, round == 0));
    sparse_rounds.push_back(join_all(local.submaps, mission, sparse, round == 0));
  }
  set_median_times(dense_rounds);
  set_median_times(sparse_rounds);
  constexpr int kBasesPerRow = 50;
  struct Bucket {
    std::vector<double> dense_ms, sparse_ms;
  };
  std::map<int, Bucket> buckets;  // by live bases
  for (std::size_t i = 0; i < local.submaps.size(); ++i) {
    Bucket& bucket = buckets[dense_rounds.front().closings[i].live_bases / kBasesPerRow * kBasesPerRow];
    bucket.dense_ms.push_back(dense_rounds.front().closings[i].global_ms);
    bucket.sparse_ms.push_back(sparse_rounds.front().closings[i].global_ms);
  }
  std::printf(
      "crossover: %td landmarks, the same %zu submaps joined with dense covariance and with sparse port factors, median of %d rounds; "
      "processor time\n",
      static_cast<std::ptrdiff_t>(world.landmarks_m.cols()), local.submaps.size(), options.rounds);
  std::printf("| live bases | closings | dense mean ms | p50 | p99 | sparse mean ms | p50 | p99 |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& [bases, bucket] : buckets) {
    std::printf("| %d to %d | %zu | %.3f | %.3f | %.3f | %.3f | %.3f | %.3f |\n", bases, bases + kBasesPerRow - 1, bucket.dense_ms.size(),
                mean(bucket.dense_ms), median(bucket.dense_ms), quantile(bucket.dense_ms, 0.99), mean(bucket.sparse_ms),
                median(bucket.sparse_ms), quantile(bucket.sparse_ms, 0.99));
  }
  for (const auto* rounds : {&dense_rounds, &sparse_rounds}) {
    const GlobalMission& first = rounds->front();
    std::printf(
        "%s: online mean %.2f m, NEES (3) %.2f; final map mean %.3f m, aligned %.3f m, landmark NEES (2) %.2f, base NEES (3) %.2f\n",
        rounds == &dense_rounds ? "dense" : "sparse", mean(first.online_m), mean(first.online_nees), first.map_mean_m, first.map_aligned_m,
        first.landmark_nees, first.base_nees);
  }
}

}  // namespace ssjs::benchmarks
