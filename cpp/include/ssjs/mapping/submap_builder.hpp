/// Builds one submap after the other with the EKF. Thesis 3.3.1, Algorithm 4; docs/math/submaps.md (C-1..C-4).
#pragma once

#include <cstdint>
#include <string>

#include "ssjs/features/feature.hpp"
#include "ssjs/mapping/landmark_map.hpp"
#include "ssjs/mapping/trajectory_journal.hpp"

namespace ssjs {

class SubmapBuilder {
 public:
  SubmapBuilder(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed);
  SubmapBuilder(const SubmapBuilder&) = delete;  // the filter reports to the journal beside it
  SubmapBuilder& operator=(const SubmapBuilder&) = delete;
  ~SubmapBuilder() = default;

  void predict(double time_s, const MotionPrediction& motion);
  [[nodiscard]] ScanResult observe(double time_s, const Features& scan);

  /// Records the present pose as a step of the trajectory.
  void record_step(double time_s);

  /// Finishes the present submap as it is, at the end of a mission.
  [[nodiscard]] Submap finish(const std::string& reason);

  [[nodiscard]] int index() const { return index_; }
  [[nodiscard]] GaussianSe2 base_T_vehicle() const { return {filter().vehicle_pose(), filter().vehicle_covariance()}; }
  [[nodiscard]] const Ekf& filter() const { return map_.filter(); }

 private:
  void start(double time_s);
  [[nodiscard]] SplitSituation situation(double time_s, const ScanAssociation& association) const;

  SubmapBuilderConfig config_;
  bool identities_known_;
  LandmarkMap map_;
  TrajectoryJournal journal_;
  int index_ = 0;
  double start_time_s_ = 0.0;
  bool started_ = false;
  double time_s_ = 0.0;
  double distance_m_ = 0.0;
};

}  // namespace ssjs
