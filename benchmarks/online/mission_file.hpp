/// A simulated mission on disk, so that whoever reads it holds a tick at a time: what the process holds then is the estimator's.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "ssjs/features/navigation_tick.hpp"

namespace ssjs::benchmarks {

struct DayConfig {
  double hours = 24.0;
  double landmarks_per_km2 = 3000.0;
  double line_length_m = 1500.0;
  double line_spacing_m = 50.0;
  int lines_per_cross = 12;  ///< a cross line for so many lines
  std::uint64_t seed = 1;
};

/// Simulates a lawn-mower with cross lines in a process of its own, which takes the memory it needed with it. Throws where that fails.
void write_mission(const std::string& path, const DayConfig& config);

class MissionFile {
 public:
  explicit MissionFile(const std::string& path);
  /// Nothing at the end.
  [[nodiscard]] std::optional<NavigationTick> next();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace ssjs::benchmarks
