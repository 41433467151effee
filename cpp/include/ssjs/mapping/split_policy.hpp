/// When a local map is finished. docs/math/submaps.md (C-1).
#pragma once

#include <optional>
#include <string>

#include "ssjs/base/config_field.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

struct SplitPolicyConfig {
  std::optional<int> max_landmarks = 15;
  std::optional<double> max_sigma_xy_m = 2.0;
  std::optional<double> max_sigma_heading_rad;
  std::optional<double> max_distance_m;
  std::optional<double> max_duration_s;
  int min_landmarks = 3;  ///< a map with fewer is closed by the landmark count only
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("max_landmarks", max_landmarks, Rule::at_least(3), "a scan that would exceed so many landmarks closes the submap");
    v.field("max_sigma_xy_m", max_sigma_xy_m, Rule::positive(), "standard deviation of the vehicle in the submap that closes it");
    v.field("max_sigma_heading_rad", max_sigma_heading_rad, Rule::positive(), "standard deviation of the heading that closes it");
    v.field("max_distance_m", max_distance_m, Rule::positive(), "distance travelled that closes it");
    v.field("max_duration_s", max_duration_s, Rule::positive(), "duration that closes it");
    v.field("min_landmarks", min_landmarks, Rule::not_negative(),
            "submaps with fewer landmarks are not closed by uncertainty, distance or time");
  }
};

/// What the policy looks at, at a scan.
struct SplitSituation {
  int landmarks = 0;      ///< confirmed ones
  int new_landmarks = 0;  ///< that this scan would add or confirm
  GaussianSe2 submap_T_vehicle;
  double distance_m = 0.0;
  double duration_s = 0.0;
};

/// The reason to close the submap at this scan, or nothing. A vehicle that has not moved gives no link, hence never a reason.
[[nodiscard]] std::optional<std::string> reason_to_close(const SplitSituation& situation, const SplitPolicyConfig& config);

}  // namespace ssjs
