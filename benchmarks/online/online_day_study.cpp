// ssjs_online_day: hours of a simulated survey through ssjs::online in one process. What a step takes, what it asks of the heap, how long
// the background works, how the memory grows. docs/embedding.md, "Steps are short".
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "../../tests/cpp/allocation/counted_heap.hpp"
#include "../cpu_clock.hpp"
#include "../quantiles.hpp"
#include "mission_file.hpp"
#include "ssjs/embed/online.hpp"

namespace ssjs::benchmarks {
namespace {

constexpr const char* kUsage =
    "usage: ssjs_online_day MISSION [--hours H] [--density LANDMARKS_PER_KM2] [--spacing-m M] [--seed N] [--known] [--real-time H] "
    "[--set KEY=VALUE]...\n"
    "  MISSION is simulated where the file is not there yet. In the last H hours (--real-time, 24) samples come in real time while the\n"
    "  background works, and before those the study waits for it between two steps; otherwise samples come as fast as they are taken.\n";

struct Options {
  std::string mission;
  DayConfig day;
  bool known = false;
  double real_time_h = 24.0;
  std::vector<std::pair<std::string, std::string>> settings;
};

Options parse(int count, char** arguments) {
  Options options;
  if (count < 2) throw std::invalid_argument("MISSION is missing");
  options.mission = arguments[1];
  for (int i = 2; i < count; ++i) {
    const std::string flag = arguments[i];
    if (flag == "--known") {
      options.known = true;
      continue;
    }
    if (i + 1 == count) throw std::invalid_argument(flag + ": needs a value");
    const std::string value = arguments[++i];
    if (flag == "--hours") {
      options.day.hours = std::stod(value);
    } else if (flag == "--density") {
      options.day.landmarks_per_km2 = std::stod(value);
    } else if (flag == "--spacing-m") {
      options.day.line_spacing_m = std::stod(value);
    } else if (flag == "--seed") {
      options.day.seed = std::stoull(value);
    } else if (flag == "--real-time") {
      options.real_time_h = std::stod(value);
    } else if (flag == "--set" && value.find('=') != std::string::npos) {
      options.settings.emplace_back(value.substr(0, value.find('=')), value.substr(value.find('=') + 1));
    } else {
      throw std::invalid_argument(flag + " " + value + ": unknown");
    }
  }
  return options;
}

double thread_cpu_s() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0.0, resident = 0.0;
  statm >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Each sensor when it speaks; all samples of one time are a step.
void feed(online::Estimator& estimator, const NavigationTick& tick, bool known) {
  const double t = tick.time_s;
  const auto taken = [&](online::Arrival arrival) {
    if (arrival != online::Arrival::kTaken) throw std::runtime_error(std::string("a sample was refused: ") + estimator.last_error());
  };
  if (tick.gyro_rad_s) taken(estimator.feed(online::Gyro{t, {tick.gyro_rad_s->x(), tick.gyro_rad_s->y(), tick.gyro_rad_s->z()}}));
  if (tick.roll_pitch_rad) taken(estimator.feed(online::Attitude{t, tick.roll_pitch_rad->x(), tick.roll_pitch_rad->y()}));
  if (tick.compass_rad) taken(estimator.feed(online::Compass{t, *tick.compass_rad}));
  if (tick.depth_m) taken(estimator.feed(online::Depth{t, *tick.depth_m}));
  if (tick.altitude_m) taken(estimator.feed(online::Altitude{t, *tick.altitude_m}));
  if (tick.velocity) {
    const Eigen::Vector3d& v = tick.velocity->velocity_m_s;
    taken(estimator.feed(online::Velocity{t, {v.x(), v.y(), v.z()}, tick.velocity->bottom_lock}));
  }
  for (const SideScanSighting& sighting : tick.sightings) {
    const Eigen::Vector3d& p = sighting.vehicle_p_point;
    online::Sighting sample{t, {p.x(), p.y(), p.z()}, true, {}, known ? sighting.landmark_id.value_or(-1) : -1};
    std::copy_n(sighting.covariance->data(), 9, sample.covariance_m2);
    taken(estimator.feed(sample));
  }
}

/// What happened in an hour.
struct Hour {
  std::vector<double> wall_ms, cpu_ms;     ///< of each step
  std::vector<double> join_cpu_s, join_s;  ///< of each closing
  long plain_steps = 0;                    ///< no map ended, no landmark was new, no ping showed several points
  long plain_allocating = 0;               ///< of them that took from the heap
  long allocations = 0;                    ///< in all steps
};

void print(double hour, const Hour& told, const online::Status& status) {
  std::printf("| %.1f | %d | %d | %.3f | %.2f | %.2f | %.1f | %.2f | %.1f | %.2f | %.2f | %.2f | %d | %ld of %ld | %ld | %.0f |\n", hour,
              status.submaps, status.loop_closures, quantile(told.wall_ms, 0.5), quantile(told.wall_ms, 0.99),
              quantile(told.wall_ms, 0.999), largest(told.wall_ms), quantile(told.cpu_ms, 0.999), largest(told.cpu_ms),
              median(told.join_cpu_s), largest(told.join_cpu_s), largest(told.join_s), status.waits, told.plain_allocating,
              told.plain_steps, told.allocations, resident_mb());
  std::fflush(stdout);
}

void run(const Options& options) {
  MissionFile mission(options.mission);
  std::vector<online::Setting> settings;
  if (options.known) settings.push_back({"association.method", "known"});
  for (const auto& [key, value] : options.settings) settings.push_back({key.c_str(), value.c_str()});
  online::Estimator estimator(settings.data(), settings.size());
  std::printf(
      "| hour | submaps | closures | step p50 ms | p99 | p99.9 | max | CPU p99.9 | max | joining CPU s, median | max | wall max | waits | "
      "plain steps that allocate | allocations | RSS MB |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  Hour hour, day;
  hour.wall_ms.reserve(40000);
  hour.cpu_ms.reserve(40000);
  online::Status before = estimator.status();
  constexpr std::uint32_t kLagging = 0xfff;  // ticks that a step lags by, the window of 1 s
  std::uint32_t searched = 0;                // the last ticks; a bit for each that showed several points at once
  double next_hour_s = 3600.0, due_s = 0.0, joining_since_s = 0.0, background_before_s = 0.0, time_s = 0.0;
  const auto background_s = [] { return process_cpu_s() - thread_cpu_s(); };
  const auto end_hour = [&] {
    print(time_s / 3600.0, hour, before);
    day.wall_ms.insert(day.wall_ms.end(), hour.wall_ms.begin(), hour.wall_ms.end());
    day.cpu_ms.insert(day.cpu_ms.end(), hour.cpu_ms.begin(), hour.cpu_ms.end());
    day.join_cpu_s.insert(day.join_cpu_s.end(), hour.join_cpu_s.begin(), hour.join_cpu_s.end());
    day.join_s.insert(day.join_s.end(), hour.join_s.begin(), hour.join_s.end());
    day.plain_steps += hour.plain_steps;
    day.plain_allocating += hour.plain_allocating;
    day.allocations += hour.allocations;
    hour.wall_ms.clear();
    hour.cpu_ms.clear();
    hour.join_cpu_s.clear();
    hour.join_s.clear();
    hour.plain_steps = hour.plain_allocating = hour.allocations = 0;
  };
  while (const std::optional<NavigationTick> tick = mission.next()) {
    if (tick->time_s > 3600.0 * options.day.hours) break;
    const double step_s = tick->time_s - time_s;
    time_s = tick->time_s;
    if (before.joining && time_s >= 3600.0 * (options.day.hours - options.real_time_h)) {
      due_s += step_s;
      const double early_s = due_s - wall_s();
      if (early_s > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(early_s));
    }
    const double wall_begin = wall_s(), cpu_begin = thread_cpu_s();
    const long allocations_before = testing::allocations;
    feed(estimator, *tick, options.known);
    const long allocations = testing::allocations - allocations_before;
    const double cpu_end = thread_cpu_s(), wall_end = wall_s();
    hour.wall_ms.push_back(1e3 * (wall_end - wall_begin));
    hour.cpu_ms.push_back(1e3 * (cpu_end - cpu_begin));
    hour.allocations += allocations;
    const online::Status now = estimator.status();
    const bool closed = now.submaps != before.submaps;
    searched = searched << 1U | (tick->sightings.size() > 1 ? 1U : 0U);
    if (!closed && now.landmarks == before.landmarks && (searched & kLagging) == 0 && now.loop_closures == before.loop_closures) {
      ++hour.plain_steps;
      hour.plain_allocating += allocations > 0 ? 1 : 0;
    }
    if (closed) {
      joining_since_s = due_s = wall_s();
      background_before_s = background_s();
    } else if (before.joining && !now.joining) {
      hour.join_s.push_back(wall_s() - joining_since_s);
      hour.join_cpu_s.push_back(background_s() - background_before_s);
    }
    before = now;
    if (before.joining && time_s < 3600.0 * (options.day.hours - options.real_time_h)) {
      while (estimator.status().joining) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (time_s >= next_hour_s) {
      end_hour();
      next_hour_s += 3600.0;
    }
  }
  if (!hour.wall_ms.empty()) end_hour();
  std::printf("all of it:\n");
  print(time_s / 3600.0, day, before);
  const double finish_s = cpu_time_s([&] {
    if (!estimator.finish()) throw std::runtime_error(estimator.last_error());
  });
  const double resident = resident_mb();
  const double cpu_s = cpu_time_s([&] { std::printf("%zu landmarks, ", estimator.landmarks(nullptr, 0)); });
  std::printf("%d submaps, %d closures; finish %.1f s, listing the landmarks %.1f s of processor time; %.0f MB before, largest %.0f MB\n",
              estimator.status().submaps, estimator.status().loop_closures, finish_s, cpu_s, resident, peak_memory_mb());
}

}  // namespace
}  // namespace ssjs::benchmarks

int main(int count, char** arguments) {
  try {
    const ssjs::benchmarks::Options options = ssjs::benchmarks::parse(count, arguments);
    if (access(options.mission.c_str(), R_OK) != 0) ssjs::benchmarks::write_mission(options.mission, options.day);
    ssjs::benchmarks::run(options);
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "ssjs_online_day: %s\n%s", error.what(), ssjs::benchmarks::kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ssjs_online_day: %s\n", error.what());
    return 1;
  }
  return 0;
}
