/// Builds one submap after the other with the EKF. Thesis 3.3.1, Algorithm 4; docs/math/submaps.md (C-1..C-4).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/mapping/scan_association.hpp"
#include "ssjs/mapping/split_policy.hpp"
#include "ssjs/mapping/submap.hpp"
#include "ssjs/mapping/trajectory_journal.hpp"

namespace ssjs {

struct SubmapBuilderConfig {
  SplitPolicyConfig split;
  bool split_boundary_scan = true;
  bool invariant_filter = true;          ///< the EKF's error form; false is the textbook filter
  int min_sightings = 1;                 ///< a landmark seen less often is tentative
  std::optional<int> prune_after_scans;  ///< tentative landmarks are dropped after so many scans
  double min_motion_m = 0.0;             ///< scans are skipped until the vehicle moved so far ...
  double min_rotation_rad = 0.0;         ///< ... or turned so far
  bool condition_trajectory = true;      ///< false: past poses stay as filtered, and nothing is remembered for them
  int max_tentative = 200;               ///< a flood of spurious observations stays bounded
  template <class Visitor>
  void visit(Visitor& v) {
    split.visit(v);
    v.field("split_boundary_scan", split_boundary_scan, "share the closing scan between the two submaps, each observation used once");
    v.field("invariant_filter", invariant_filter,
            "corrections in right-invariant coordinates: more consistent headings than the textbook EKF");
    v.field("min_sightings", min_sightings, Rule::at_least(1), "landmarks seen less often are tentative: not counted, dropped at closing");
    v.field("prune_after_scans", prune_after_scans, Rule::at_least(1), "tentative landmarks are dropped after so many scans");
    v.field("min_motion_m", min_motion_m, Rule::not_negative(),
            "scans are skipped until the vehicle has moved so far since the last used one");
    v.field("min_rotation_rad", min_rotation_rad, Rule::not_negative(), "... or has turned so far");
    v.field("condition_trajectory", condition_trajectory,
            "past poses of a submap follow its later corrections (costs memory in proportion to a submap)");
    v.field("max_tentative", max_tentative, Rule::at_least(1),
            "tentative landmarks kept at most: a flood of spurious observations stays bounded");
  }
};

/// An observation that entered the estimate, and the track it belongs to: the observations of one landmark in one submap.
struct UsedObservation {
  Feature feature;
  std::int64_t track = 0;  ///< MapLandmark::tracks says which landmark that became
};

struct ScanResult {
  std::optional<UpdateResult> update;      ///< absent when nothing was paired or the scan was skipped
  int paired = 0, added = 0, dropped = 0;  ///< each observation of a used scan is in one of them
  std::vector<UsedObservation> used;       ///< the paired ones, then the added ones
  int wrong_pairs = 0;                     ///< pairs whose source identities differ, where both are known
  bool budget_exhausted = false;
  double association_time_s = 0.0;
  std::optional<Submap> closed;  ///< the submap that this scan finished; the builder is already in the next one
};

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
  [[nodiscard]] GaussianSe2 base_T_vehicle() const { return {ekf_.vehicle_pose(), ekf_.vehicle_covariance()}; }
  [[nodiscard]] const Ekf& filter() const { return ekf_; }

 private:
  void start(double time_s);
  void add(const Feature& feature, ScanResult& result);  ///< nothing when there are too many tentative landmarks
  void update(const Features& scan, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& selected, ScanResult& result);
  void prune();
  void remove(Eigen::Index landmark);
  [[nodiscard]] SplitSituation situation(double time_s, const ScanAssociation& association) const;
  [[nodiscard]] bool confirmed(const MapLandmark& landmark) const { return landmark.times_seen >= config_.min_sightings; }

  SubmapBuilderConfig config_;
  bool identities_known_;
  ScanAssociator associator_;
  Ekf ekf_;
  std::vector<MapLandmark> landmarks_;  ///< in the order of the filter's
  std::vector<int> first_scan_;         ///< of each landmark
  TrajectoryJournal journal_;
  int index_ = 0;
  std::int64_t tracks_ = 0;  ///< begun so far
  int scans_ = 0;
  double start_time_s_ = 0.0;
  bool started_ = false;
  double time_s_ = 0.0;
  double distance_m_ = 0.0;
  double moved_m_ = 0.0;  ///< since the last used scan
  double turned_rad_ = 0.0;
  bool scan_due_ = true;
};

}  // namespace ssjs
