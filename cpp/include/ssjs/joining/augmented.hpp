/// EKF-SLAM with map management (the augmented EKF of the sonar papers): landmarks that stay unseen where they should be seen leave the
/// map. docs/math/single_map.md (G-1..G-5).
#pragma once

#include <cstdint>
#include <map>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/filter_mapper.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {

struct AugmentedEkfConfig {
  int view_window = 10;
  int max_missed_views = 8;
  int permanent_sightings = 3;
  double field_of_view_rad = 6.28318530717958623;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("view_window", view_window, Rule::closed(1, 64), "expected views of a landmark that are remembered");
    v.field("max_missed_views", max_missed_views, Rule::closed(1, 64), "a landmark unseen in so many of them is removed");
    v.field("permanent_sightings", permanent_sightings, Rule::at_least(2), "a landmark seen so often is never removed");
    v.field("field_of_view_rad", field_of_view_rad, Rule::closed(0.01, 6.2831853071795872),
            "angle that the sensor sees, half of it on either side of straight ahead");
  }
};

class AugmentedEkfMapper final : public FilterMapper {
 public:
  AugmentedEkfMapper(const AugmentedEkfConfig& config, const RangeBearingConfig& sensor, const SubmapBuilderConfig& submap,
                     const ScanAssociationConfig& association, std::uint64_t seed);

  [[nodiscard]] MapperReport observe(double time_s, const Features& scan) override;
  [[nodiscard]] JoinReport finish() override;
  [[nodiscard]] WorldEstimate world(BaseCovariance covariance) const override;

 private:
  struct Views {
    int times_seen = 0;
    std::uint64_t missed = 0;  ///< the last expected views, newest in the lowest bit
  };
  /// The landmarks that a scan from here has to show, with three standard deviations to spare.
  [[nodiscard]] std::vector<bool> expected_in_view();
  void manage(const std::vector<bool>& expected);

  AugmentedEkfConfig config_;
  RangeBearingConfig sensor_;
  double farthest_m_ = 0.0;     ///< observation so far
  std::map<int, Views> views_;  ///< by label
  int next_label_ = 0;
  PairingProblem problem_;
};

}  // namespace ssjs
