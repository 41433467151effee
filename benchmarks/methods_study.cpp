#include <cmath>
#include <cstdio>

#include "../tests/cpp/pipeline/scenario_run.hpp"
#include "cpu_clock.hpp"
#include "quantiles.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

struct NamedMethod {
  const char* name;
  Method method;
};
constexpr NamedMethod kMethods[] = {{"ekf", Method::kEkf},
                                    {"lmj", Method::kSequential},
                                    {"clsf", Method::kConstrainedLocal},
                                    {"dcs", Method::kDivideAndConquer},
                                    {"hs", Method::kHierarchical},
                                    {"ssjs", Method::kSelective},
                                    {"ssjs-thesis", Method::kSelectiveThesis}};

using testing::ScenarioResult;

double mean_of(const std::vector<ScenarioResult>& runs, double ScenarioResult::*value) {
  std::vector<double> values;
  for (const ScenarioResult& run : runs) values.push_back(run.*value);
  return mean(values);
}
double mean_of(const std::vector<ScenarioResult>& runs, int ScenarioResult::*value) {
  std::vector<double> values;
  for (const ScenarioResult& run : runs) values.push_back(run.*value);
  return mean(values);
}
/// Processor time of the mission alone.
double time_mission(const SimulatedMission& mission, const SlamConfig& config, std::uint64_t seed) {
  SlamPipeline pipeline(config, seed);
  return cpu_time_s([&] {
    for (const Event& event : mission.events) static_cast<void>(pipeline.feed(event));
    static_cast<void>(pipeline.finish());
  });
}

}  // namespace

void study_methods(const StudyOptions& options) {
  std::printf("grid-survey, %s association, %d seeds from %d on; processor times are medians, the rest means\n",
              options.association.c_str(), options.seeds, static_cast<int>(options.seed));
  std::printf(
      "| method | total s | of it joining s | map m | worst seed m | aligned m | online m | final m | joint NEES/dof | base NEES "
      "(3) "
      "| online NEES (3) | fusions | loops | wrong pairs |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const NamedMethod& named : kMethods) {
    std::vector<ScenarioResult> runs;
    std::vector<double> total_s, joining_s;
    double worst_m = 0.0;
    for (int i = 0; i < options.seeds; ++i) {
      const auto seed = options.seed + static_cast<std::uint64_t>(i);
      const Scenario scenario = built_in_scenario("grid-survey", seed);
      SlamConfig config = testing::matching_config(scenario.config);
      config.method = named.method;
      if (options.association == "jcbb") {
        config.association.method = AssociationMethod::kJointCompatibility;
        config.joining.max_pairing_sigma_m = 0.8;  // 0.16 cells of the grid
      }
      const SimulatedMission mission = simulate(scenario.world, scenario.config, seed);
      runs.push_back(testing::run_scenario(mission, config, seed));
      ScenarioResult& run = runs.back();
      if (run.submaps == 1) run.online_mean_m = run.online_nees_mean = std::nan("");  // measured at closings
      total_s.push_back(time_mission(mission, config, seed));
      joining_s.push_back(total_s.back() * (run.global_s + run.association_s) / run.total_s);  // the share was measured in wall time
      worst_m = std::max(worst_m, run.map_mean_m);
    }
    std::printf("| %s | %.3f | %.3f | %.2f | %.2f | %.3f | %.2f | %.2f | %.2f | %.1f | %.1f | %.0f | %.0f | %.1f |\n", named.name,
                median(total_s), median(joining_s), mean_of(runs, &ScenarioResult::map_mean_m), worst_m,
                mean_of(runs, &ScenarioResult::aligned_mean_m), mean_of(runs, &ScenarioResult::online_mean_m),
                mean_of(runs, &ScenarioResult::final_m), mean_of(runs, &ScenarioResult::joint_nees_per_dof),
                mean_of(runs, &ScenarioResult::base_nees_mean), mean_of(runs, &ScenarioResult::online_nees_mean),
                mean_of(runs, &ScenarioResult::fusions), mean_of(runs, &ScenarioResult::loop_closures),
                mean_of(runs, &ScenarioResult::map_wrong_pairs));
    std::fflush(stdout);
  }
}

}  // namespace ssjs::benchmarks
