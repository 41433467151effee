/// What the pipeline feeds: it keeps the map and the vehicle's place in it. Submaps with a joining method, or a filter of another kind.
#pragma once

#include <optional>
#include <vector>

#include "ssjs/features/feature.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/mapping/submap_builder.hpp"

namespace ssjs {

/// What one scan did.
struct MapperReport {
  ScanResult scan;
  std::optional<JoinReport> join;  ///< when the scan closed a submap
  double join_time_s = 0.0;        ///< wall time spent outside the local map, in that or in fetching landmarks of other maps
};

class Mapper {
 public:
  Mapper() = default;
  Mapper(const Mapper&) = delete;
  Mapper& operator=(const Mapper&) = delete;
  virtual ~Mapper() = default;

  /// The vehicle in the frame of the present submap, where its motion is to be linearised.
  [[nodiscard]] virtual const Se2& base_T_vehicle() const = 0;
  virtual void predict(double time_s, const MotionPrediction& motion) = 0;
  [[nodiscard]] virtual MapperReport observe(double time_s, const Features& scan) = 0;
  /// The present pose becomes a step of the trajectory.
  virtual void record_step(double time_s) = 0;
  [[nodiscard]] virtual GaussianSe2 global_T_vehicle() const = 0;
  [[nodiscard]] virtual int submap() const = 0;  ///< the present one

  /// The end of the mission; no event may follow.
  [[nodiscard]] virtual JoinReport finish() = 0;
  [[nodiscard]] virtual const std::vector<Submap>& submaps() const = 0;  ///< the finished ones, with the trajectory inside
  [[nodiscard]] virtual WorldEstimate world(BaseCovariance covariance) const = 0;
};

}  // namespace ssjs
