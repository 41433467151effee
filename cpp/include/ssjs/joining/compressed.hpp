/// The compressed EKF (Guivant and Nebot 2001): the filter works on the region around the vehicle, the rest follows when the region
/// changes. The answer of the EKF over everything. docs/math/single_map.md (G-6..G-11).
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/filter/compressed_map.hpp"
#include "ssjs/filter/compression.hpp"
#include "ssjs/joining/filter_mapper.hpp"

namespace ssjs {

struct CompressedEkfConfig {
  std::optional<double> region_m;
  std::optional<double> sight_m;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("region_m", region_m, Rule::positive(),
            "the region changes when the vehicle is so far from where it entered; without it, the sensor's sight");
    v.field("sight_m", sight_m, Rule::positive(),
            "landmarks so far beyond the region are in it too; without it, the farthest observation so far, at most sensor.max_range_m");
  }
};

class CompressedEkfMapper final : public FilterMapper {
 public:
  CompressedEkfMapper(const CompressedEkfConfig& config, double max_range_m, const SubmapBuilderConfig& submap,
                      const ScanAssociationConfig& association, std::uint64_t seed);

  [[nodiscard]] MapperReport observe(double time_s, const Features& scan) override;
  [[nodiscard]] JoinReport finish() override;
  [[nodiscard]] WorldEstimate world(BaseCovariance covariance) const override;

  [[nodiscard]] int region_changes() const { return region_changes_; }

 private:
  /// Whether the identities of the scan show a passive landmark.
  [[nodiscard]] bool shows_passive(const Features& scan) const;
  /// Distance from the vehicle within which landmarks have to be active for this scan.
  [[nodiscard]] double needed_m(const Features& scan) const;
  /// With known identities the landmarks of the scan are active wherever they are.
  void change_region(double radius_m, const Features& scan);
  /// Slots of the filter's landmarks, negative for new ones.
  [[nodiscard]] std::vector<Eigen::Index> active_slots() const;
  /// The whole map, brought up to date; landmarks in the order of the slots.
  [[nodiscard]] MapState whole(std::vector<MapLandmark>& landmarks) const;
  void settle();  ///< the map and its books take over what the filter holds

  CompressedEkfConfig config_;
  double max_range_m_;
  bool identities_known_;
  CompressedMap whole_;
  Compression compression_;
  std::vector<TrackedLandmark> books_;  ///< by slot, stale for active ones
  std::set<std::int64_t> passive_identities_;
  double passive_variance_ = 0.0;  ///< largest trace of a passive landmark's covariance, at the last change
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double radius_m_ = 0.0;    ///< of the active landmarks about the centre
  double farthest_m_ = 0.0;  ///< observation so far
  int region_changes_ = 0;
};

}  // namespace ssjs
