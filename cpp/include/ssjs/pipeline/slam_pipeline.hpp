/// The whole of SLAM, fed one event at a time. Thesis Algorithms 3 and 4; docs/architecture.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "ssjs/features/event.hpp"
#include "ssjs/features/persistence_filter.hpp"
#include "ssjs/joining/mapper.hpp"
#include "ssjs/pipeline/final_trajectory.hpp"
#include "ssjs/pipeline/motion.hpp"
#include "ssjs/pipeline/slam_config.hpp"

namespace ssjs {

/// What one event did.
struct StepReport {
  double time_s = 0.0;
  GaussianSe2 global_T_vehicle;  ///< after the event
  int submap = 0;
  std::optional<ScanResult> scan;  ///< of an observation event
  std::optional<JoinReport> join;  ///< when the event closed a submap
  double global_time_s = 0.0;      ///< wall time spent in the joining layer, without association
  double association_time_s = 0.0;
};

class SlamPipeline {
 public:
  /// Throws InvalidArgument listing every violation of the configuration.
  SlamPipeline(const SlamConfig& config, std::uint64_t seed);

  /// Times must not decrease and values must be finite: otherwise InvalidArgument, and nothing has changed.
  StepReport feed(const Event& event);

  [[nodiscard]] GaussianSe2 global_T_vehicle() const { return mapper_->global_T_vehicle(); }
  [[nodiscard]] const Se2& dead_reckoning() const { return dead_reckoning_; }

  /// Closes the last submap and lets the joining layer settle. No event may follow. Returns what that closing did.
  JoinReport finish();

  /// The final trajectory, one point an event; after finish().
  [[nodiscard]] std::vector<TrajectoryPoint> trajectory() const { return final_trajectory(submaps(), world()); }
  [[nodiscard]] const std::vector<Submap>& submaps() const { return mapper_->submaps(); }
  [[nodiscard]] WorldEstimate world(BaseCovariance covariance = BaseCovariance::kBorders) const { return mapper_->world(covariance); }

 private:
  void move(const Event& event);
  void observe(const Features& scan, StepReport& report);

  SlamConfig config_;
  std::unique_ptr<Mapper> mapper_;
  OdometryMotion motion_;
  PersistenceFilter persistence_;
  Se2 dead_reckoning_;
  std::optional<double> time_s_;
  bool finished_ = false;
};

}  // namespace ssjs
