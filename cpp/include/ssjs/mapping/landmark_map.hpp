/// A filter with the books of its landmarks: what one scan does to a map, whatever becomes of the map. Thesis Algorithm 4;
/// docs/math/submaps.md.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/features/feature.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/mapping/scan_association.hpp"
#include "ssjs/mapping/submap.hpp"
#include "ssjs/mapping/submap_config.hpp"

namespace ssjs {

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

/// One landmark of the map, in the order of the filter's.
struct TrackedLandmark {
  MapLandmark landmark;
  int first_scan = 0;  ///< numbers of used scans
  int last_scan = 0;   ///< the last one that it was paired in
  int label = -1;      ///< given by the owner of the map; negative: none yet
};

/// Observations that repeat are paired and correct the filter; those outside the dead band become landmarks; landmarks seen fewer than
/// min_sightings times are tentative.
class LandmarkMap {
 public:
  LandmarkMap(const SubmapBuilderConfig& config, const ScanAssociationConfig& association, std::uint64_t seed, ErrorForm error_form,
              StateLayout layout = {});
  LandmarkMap(const LandmarkMap&) = delete;  // whoever watches the filter keeps its address
  LandmarkMap& operator=(const LandmarkMap&) = delete;
  ~LandmarkMap() = default;

  void clear(const GaussianSe2& frame_T_vehicle = {});
  void predict(const MotionPrediction& motion);

  /// The whole of a scan: skipped, or associated, used to correct and to add; tentative landmarks grow old.
  [[nodiscard]] ScanResult observe(const Features& scan);

  // Its parts, for a map that ends at a scan.
  /// Counts the scan; false when the vehicle has not moved enough since the last used one.
  [[nodiscard]] bool takes_scan();
  const ScanAssociation& associate(const Features& scan, ScanResult& result);
  void update(const Features& scan, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& selected, ScanResult& result);
  void add(const Feature& feature, ScanResult& result);  ///< nothing when there are too many tentative landmarks
  void prune();                                          ///< tentative landmarks that are too old
  void drop_tentative();

  /// Marginalises a landmark out; the last one takes its index.
  void remove(Eigen::Index landmark);
  /// A landmark known from elsewhere, as in Ekf::add_dependent_landmark.
  void add_known(const TrackedLandmark& landmark, const Eigen::Vector2d& position,
                 const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& J_state, const Eigen::Matrix2d& noise);
  void set_label(Eigen::Index landmark, int label) { labels_[static_cast<std::size_t>(landmark)] = label; }
  /// The books of a filter that was restored to another state.
  void restore_books(const std::vector<TrackedLandmark>& landmarks);

  [[nodiscard]] Ekf& filter() { return ekf_; }
  [[nodiscard]] const Ekf& filter() const { return ekf_; }
  [[nodiscard]] Eigen::Index size() const { return ekf_.landmarks(); }
  [[nodiscard]] const std::vector<MapLandmark>& landmarks() const { return landmarks_; }
  [[nodiscard]] TrackedLandmark tracked(Eigen::Index landmark) const;
  [[nodiscard]] bool confirmed(const MapLandmark& landmark) const { return landmark.times_seen >= config_.min_sightings; }
  [[nodiscard]] int scans() const { return scans_; }  ///< used ones since clear()
  /// Confirmed landmarks that this association would add.
  [[nodiscard]] int new_landmarks(const ScanAssociation& association) const;

 private:
  SubmapBuilderConfig config_;
  ScanAssociator associator_;
  Ekf ekf_;
  std::vector<MapLandmark> landmarks_;  ///< in the order of the filter's, as the next three
  std::vector<int> first_scan_, last_scan_, labels_;
  std::int64_t tracks_ = 0;  ///< begun so far
  int scans_ = 0;
  double moved_m_ = 0.0;  ///< since the last used scan
  double turned_rad_ = 0.0;
  bool scan_due_ = true;
};

}  // namespace ssjs
