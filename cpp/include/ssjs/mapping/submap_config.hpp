/// How local maps are built. docs/math/submaps.md.
#pragma once

#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/mapping/split_policy.hpp"

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

}  // namespace ssjs
