/// Only what was there in an earlier scan too: glints and pieces of walls move with the viewpoint. docs/math/sonar_points.md (F-4).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/geometry/se2.hpp"

namespace ssjs {

struct PersistenceConfig {
  int min_earlier_sightings = 0;
  int window_scans = 5;
  double gate_m = 0.8;
  double gate_growth_m = 0.12;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("min_earlier_sightings", min_earlier_sightings, Rule::not_negative(),
            "an observation is used if so many of the scans before it saw something there; 0: all are used");
    v.field("window_scans", window_scans, Rule::at_least(1), "how many scans before it are asked");
    v.field("gate_m", gate_m, Rule::positive(), "how near something must lie to be the same, in the scan just before");
    v.field("gate_growth_m", gate_growth_m, Rule::not_negative(), "drift of dead reckoning added to the gate for every scan further back");
  }
};

/// Compares scans through dead reckoning alone, never through the estimate: what the map believes cannot confirm itself. An observation is
/// handed on once, in its own scan; earlier scans only vote, so that no measurement is used twice.
class PersistenceFilter {
 public:
  explicit PersistenceFilter(const PersistenceConfig& config) : config_(config) {}

  /// The next scan, seen from that pose of dead reckoning: those of its features that enough earlier scans confirm.
  [[nodiscard]] Features confirmed(const Features& scan, const Se2& odometry_T_vehicle);

 private:
  using Points = std::vector<Eigen::Vector2d>;
  [[nodiscard]] int earlier_sightings(const Eigen::Vector2d& odometry_p_feature) const;

  PersistenceConfig config_;
  std::deque<Points> earlier_;  ///< positions in the frame of dead reckoning, the latest scan first
};

}  // namespace ssjs
