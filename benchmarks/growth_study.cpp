// Every method over the number of landmarks: how long a step takes, how much memory, and where a method stops being usable.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <new>
#include <stdexcept>
#include <type_traits>

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
constexpr NamedMethod kMethods[] = {{"ssjs", Method::kSelective},
                                    {"ekf", Method::kEkf},
                                    {"aekf", Method::kAugmentedEkf},
                                    {"cekf", Method::kCompressedEkf},
                                    {"cis", Method::kConditionallyIndependent},
                                    {"lmj", Method::kSequential},
                                    {"clsf", Method::kConstrainedLocal},
                                    {"dcs", Method::kDivideAndConquer},
                                    {"hs", Method::kHierarchical},
                                    {"ssjs-thesis", Method::kSelectiveThesis}};

struct Field {
  int columns, rows;
};
constexpr Field kFields[] = {{25, 10}, {25, 20}, {50, 20}, {50, 40}, {100, 50}, {100, 100}, {200, 100}};

constexpr double kSpacing_m = 5.0;
constexpr double kSlowestStepS = 1.0;        // p99 in the last tenth of the mission
constexpr rlim_t kMemoryBytes = 8000000000;  // address space of a point's process
constexpr unsigned kWallTimesLimit = 20;     // wall time after which a point's process is ended, in limits

/// What a point's process tells. Plain bytes: it goes through a pipe.
struct Point {
  char reason[200] = "";  ///< why the mission was not finished
  double done = 0.0;      ///< fraction of the events
  double mission_s = 0.0;
  double total_s = 0.0;                         ///< all steps, processor time
  double step_p50_us = 0.0, step_p99_ms = 0.0;  ///< in the last tenth of what was done
  double step_max_ms = 0.0;                     ///< of all steps
  double end_s = 0.0;                           ///< closing the mission and the estimate of everything
  double map_mean_m = 0.0;
  double memory_mb = 0.0;
};
static_assert(std::is_trivially_copyable_v<Point>);

void give_reason(Point& point, const char* text) { std::snprintf(point.reason, sizeof point.reason, "%s", text); }

/// A lawn mower away from the start, its lines 20 m apart, and back between them: the way back sees again what the way out saw, the
/// first line last.
World out_and_back(const Field& field, std::uint64_t seed) {
  World world = grid_field(field.columns, field.rows, kSpacing_m, 1.0, seed);
  const double left_m = 0.5 * kSpacing_m;
  const double right_m = kSpacing_m * (field.columns - 1.5);
  const double height_m = kSpacing_m * (field.rows - 1);
  std::vector<double> lines_m;
  for (double y_m = left_m; y_m <= height_m; y_m += 4.0 * kSpacing_m) lines_m.push_back(y_m);
  const double last_out_m = lines_m.back();
  for (double y_m = last_out_m + 2.0 * kSpacing_m; y_m > 0.0; y_m -= 4.0 * kSpacing_m) {
    if (y_m <= height_m) lines_m.push_back(y_m);
  }
  bool rightwards = true;
  for (const double y_m : lines_m) {
    world.waypoints.emplace_back(rightwards ? left_m : right_m, y_m);
    world.waypoints.emplace_back(rightwards ? right_m : left_m, y_m);
    rightwards = !rightwards;
  }
  return world;
}

double map_error_of(const WorldEstimate& estimate, const World& world) {
  Eigen::Matrix2Xd landmarks_m(2, static_cast<Eigen::Index>(estimate.landmarks.size()));
  std::vector<std::optional<std::int64_t>> ids;
  for (const LandmarkEstimate& landmark : estimate.landmarks) {
    landmarks_m.col(static_cast<Eigen::Index>(ids.size())) = landmark.position.mean;
    ids.push_back(landmark.landmark.source_id);
  }
  MapErrorConfig config;
  config.max_distance_m = 1000.0;
  const auto error = map_error(landmarks_m, ids, world.landmarks_m, world.ids, config);
  return error ? error->mean_m : std::nan("");
}

void run_point(const SimulatedMission& mission, SlamConfig config, const StudyOptions& options, Point& point) {
  config.joining.max_pairing_sigma_m.reset();
  const double limit_s = options.limit_s;
  SlamPipeline pipeline(config, options.seed);
  std::vector<double> step_s;
  const std::size_t events = mission.events.size();
  step_s.reserve(events);
  point.mission_s = mission.events.back().time_s;
  const auto summarize = [&] {
    point.step_max_ms = 1e3 * largest(step_s);
    const std::vector<double> last(step_s.end() - static_cast<std::ptrdiff_t>((step_s.size() + 9) / 10), step_s.end());
    point.done = static_cast<double>(step_s.size()) / static_cast<double>(events);
    point.step_p50_us = 1e6 * median(last);
    point.step_p99_ms = 1e3 * quantile(last, 0.99);
    point.memory_mb = peak_memory_mb();
  };
  try {
    for (const Event& event : mission.events) {
      step_s.push_back(cpu_time_s([&] { static_cast<void>(pipeline.feed(event)); }));
      point.total_s += step_s.back();
      if (point.total_s > limit_s) {
        give_reason(point, "time");
        break;
      }
    }
    summarize();
    if (point.reason[0] != '\0') return;
    WorldEstimate world;
    point.end_s = cpu_time_s([&] {
      static_cast<void>(pipeline.finish());
      world = pipeline.world(BaseCovariance::kBorders);
    });
    point.memory_mb = peak_memory_mb();
    point.map_mean_m = map_error_of(world, mission.world);
    if (point.step_p99_ms > 1e3 * kSlowestStepS) give_reason(point, "steps");
  } catch (const std::bad_alloc&) {
    if (point.done < 1.0) summarize();
    give_reason(point, "memory");
  } catch (const std::exception& error) {
    if (point.done < 1.0) summarize();
    give_reason(point, error.what());
  }
}

/// In a process of its own, whose largest memory is that of the point, with a limit on memory and, roughly, on wall time.
Point point_of(const NamedMethod& named, const Field& field, const StudyOptions& options) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("growth: no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("growth: no process");
  if (child == 0) {
    close(ends[0]);
    const rlimit memory{kMemoryBytes, kMemoryBytes};
    Point point;
    alarm(kWallTimesLimit * static_cast<unsigned>(options.limit_s));  // RLIMIT_CPU would coarsen the clock of the process
    try {
      if (setrlimit(RLIMIT_AS, &memory) != 0) throw std::runtime_error("no limit of memory");
      const VehicleSimulationConfig simulation = large_world_config();
      const SimulatedMission mission = simulate(out_and_back(field, options.seed), simulation, options.seed);
      SlamConfig config = testing::matching_config(simulation);
      config.method = named.method;
      run_point(mission, config, options, point);
    } catch (const std::exception& error) {
      give_reason(point, error.what());
    }
    const bool told = write(ends[1], &point, sizeof point) == static_cast<ssize_t>(sizeof point);
    _exit(told ? 0 : 1);
  }
  close(ends[1]);
  Point point;
  const ssize_t told = read(ends[0], &point, sizeof point);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (told != static_cast<ssize_t>(sizeof point)) {
    point = Point{};
    give_reason(point, WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM ? "time, in one step" : "its process died");
  }
  return point;
}

}  // namespace

void study_growth(const StudyOptions& options) {
  const auto is_asked_for = [&](const NamedMethod& named) { return options.method.empty() || options.method == named.name; };
  if (std::none_of(std::begin(kMethods), std::end(kMethods), is_asked_for)) {
    throw std::invalid_argument("--method " + options.method + ": is no method");
  }
  std::printf(
      "out and back over a growing field, known association, seed %d; processor time, each point in a process of its own. A method goes on "
      "until the p99 of its steps in the last tenth of the mission passes %.0f s, its memory %.0f GB, or its steps in all %.0f s; p50 and "
      "p99 are of the last tenth, max of all steps.\n",
      static_cast<int>(options.seed), kSlowestStepS, 1e-9 * static_cast<double>(kMemoryBytes), static_cast<double>(options.limit_s));
  std::printf(
      "| method | landmarks | steps in all s | step p50 us | p99 ms | max ms | end s | memory MB | map error m | |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const NamedMethod& named : kMethods) {
    if (!is_asked_for(named)) continue;
    for (const Field& field : kFields) {
      const Point point = point_of(named, field, options);
      const bool ended = point.reason[0] != '\0';
      std::printf("| `%s` | %d | %.2f | %.1f | %.2f | %.1f | ", named.name, field.columns * field.rows, point.total_s, point.step_p50_us,
                  point.step_p99_ms, point.step_max_ms);
      if (point.map_mean_m > 0.0) {
        std::printf("%.2f | %.0f | %.2f | %s |\n", point.end_s, point.memory_mb, point.map_mean_m, ended ? point.reason : "");
      } else {
        std::printf(" | %.0f | | %s, %.0f %% done |\n", point.memory_mb, point.reason, 100.0 * point.done);
      }
      std::fflush(stdout);
      if (ended) break;
    }
  }
}

}  // namespace ssjs::benchmarks
