/// Processor time of this process: what a shared machine does meanwhile is not counted.
#pragma once

#include <sys/resource.h>

#include <ctime>

namespace ssjs::benchmarks {

inline double process_cpu_s() {
  std::timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor time of `work()`, s.
template <class Work>
double cpu_time_s(Work&& work) {
  const double begin = process_cpu_s();
  work();
  return process_cpu_s() - begin;
}

/// Largest resident memory of the process so far, MB.
inline double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;
}

}  // namespace ssjs::benchmarks
