// The table of docs/faults.md: what goes wrong, what the estimator says of it, what it costs, and when the estimate is right again.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "cpu_clock.hpp"
#include "pipeline/fault_run.hpp"
#include "study.hpp"

namespace ssjs::benchmarks {
namespace {

const char* name_of(SurveyHealth health) {
  constexpr const char* kNames[] = {"waiting", "good", "degraded", "lost"};
  return kNames[static_cast<std::size_t>(health)];
}

struct Row {
  std::string name, detected, health;
  double during_m = 0.0, during_sigmas = 0.0, after_m = 0.0, rmse_m = 0.0, recovered_s = 0.0, cpu_s = 0.0;
  int closures = 0, fixes = 0;
  int recovered = 0, within = 0, failures = 0, runs = 0;
};

}  // namespace

void study_faults(const StudyOptions& options) {
  std::vector<Row> rows;
  for (int i = 0; i < options.seeds; ++i) {
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
    const SimulatedSurvey survey = testing::two_dives(seed);
    const std::vector<testing::FaultCase> faults = testing::faults(survey);
    rows.resize(faults.size());
    for (std::size_t f = 0; f < faults.size(); ++f) {
      if (faults[f].name.find(options.method) == std::string::npos) continue;
      std::fprintf(stderr, "seed %d: %s\n", static_cast<int>(seed), faults[f].name.c_str());
      testing::FaultOutcome outcome;
      Row& row = rows[f];
      row.cpu_s = std::max(row.cpu_s, cpu_time_s([&] { outcome = testing::run_fault(survey, faults[f], seed); }));
      row.name = faults[f].name;
      if (!outcome.notes.empty() && row.detected.empty()) row.detected = outcome.notes.front();
      if (row.health.find(name_of(outcome.worst)) == std::string::npos)
        row.health += (row.health.empty() ? "" : ", ") + std::string(name_of(outcome.worst));
      row.during_m = std::max(row.during_m, outcome.during_m);
      row.during_sigmas = std::max(row.during_sigmas, outcome.during_sigmas);
      row.after_m = std::max(row.after_m, outcome.after_m);
      row.rmse_m = std::max(row.rmse_m, outcome.final_rmse_m);
      row.failures += outcome.failures;
      ++row.runs;
      if (!outcome.recovered_s) continue;
      ++row.recovered;
      row.recovered_s = std::max(row.recovered_s, *outcome.recovered_s);
      row.closures = std::max(row.closures, outcome.closures_until);
      row.fixes = std::max(row.fixes, outcome.fixes_until);
      row.within += outcome.closures_until <= 2 || outcome.fixes_until == 1 ? 1 : 0;
    }
  }
  std::printf(
      "| fault | said, first | health | error m | in sigmas | back inside 3 sigma after s | closures, fixes until then | inside within 2 "
      "closures or a fix | after m | whole way RMSE m | threw |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows) {
    if (row.runs == 0) continue;
    std::printf("| %s | %s | %s | %.1f | %.1f | %.0f | %d, %d | %d of %d | %.1f | %.2f | %d |\n", row.name.c_str(), row.detected.c_str(),
                row.health.c_str(), row.during_m, row.during_sigmas, row.recovered_s, row.closures, row.fixes, row.within, row.runs,
                row.after_m, row.rmse_m, row.failures);
  }
  double slowest_s = 0.0;
  for (const Row& row : rows) slowest_s = std::max(slowest_s, row.cpu_s);
  std::printf("\nslowest run: %.1f s of processor time\n", slowest_s);
}

}  // namespace ssjs::benchmarks
