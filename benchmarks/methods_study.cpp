#include <cstdio>

#include "../tests/cpp/pipeline/scenario_run.hpp"
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
double median_of(const std::vector<ScenarioResult>& runs, double ScenarioResult::*value) {
  std::vector<double> values;
  for (const ScenarioResult& run : runs) values.push_back(run.*value);
  return median(values);
}

}  // namespace

void study_methods(const StudyOptions& options) {
  std::printf("grid-survey, %s association, %d seeds from %d on; wall times are medians, the rest means\n", options.association.c_str(),
              options.seeds, static_cast<int>(options.seed));
  std::printf(
      "| method | total s | global s | association s | map m | worst seed m | aligned m | online m | final m | joint NEES/dof | base NEES "
      "(3) "
      "| online NEES (3) | fusions | loops | wrong pairs |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const NamedMethod& named : kMethods) {
    std::vector<ScenarioResult> runs;
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
      runs.push_back(testing::run_scenario(simulate(scenario.world, scenario.config, seed), config, seed));
      worst_m = std::max(worst_m, runs.back().map_mean_m);
    }
    std::printf("| %s | %.3f | %.3f | %.3f | %.2f | %.2f | %.3f | %.2f | %.2f | %.2f | %.1f | %.1f | %.0f | %.0f | %.1f |\n", named.name,
                median_of(runs, &ScenarioResult::total_s), median_of(runs, &ScenarioResult::global_s),
                median_of(runs, &ScenarioResult::association_s), mean_of(runs, &ScenarioResult::map_mean_m), worst_m,
                mean_of(runs, &ScenarioResult::aligned_mean_m), mean_of(runs, &ScenarioResult::online_mean_m),
                mean_of(runs, &ScenarioResult::final_m), mean_of(runs, &ScenarioResult::joint_nees_per_dof),
                mean_of(runs, &ScenarioResult::base_nees_mean), mean_of(runs, &ScenarioResult::online_nees_mean),
                mean_of(runs, &ScenarioResult::fusions), mean_of(runs, &ScenarioResult::loop_closures),
                mean_of(runs, &ScenarioResult::map_wrong_pairs));
    std::fflush(stdout);
  }
}

}  // namespace ssjs::benchmarks
