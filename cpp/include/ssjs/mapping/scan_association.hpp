/// Which observation of a scan is of which landmark of a filter, and which show a new one. docs/math/association.md.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/base/config_field.hpp"
#include "ssjs/base/random.hpp"
#include "ssjs/features/feature.hpp"
#include "ssjs/filter/ekf.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

enum class AssociationMethod { kKnown, kNearestNeighbour, kJointCompatibility, kRandomizedJointCompatibility };

struct ScanAssociationConfig {
  AssociationMethod method = AssociationMethod::kJointCompatibility;
  double gate_probability = 0.99;
  double joint_gate_probability = 0.99;
  double new_landmark_squared_distance = 25.0;  ///< the dead band: nearer than this to any landmark is not new
  int node_budget = 600;
  std::optional<double> identity_gate_probability;  ///< known identities: pairs outside are misread and dropped
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("method", method,
             Choices<AssociationMethod>{{"jcbb", AssociationMethod::kJointCompatibility},
                                        {"nn", AssociationMethod::kNearestNeighbour},
                                        {"rjc", AssociationMethod::kRandomizedJointCompatibility},
                                        {"known", AssociationMethod::kKnown}},
             "how observations find their landmarks, in scans and between submaps");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing in a scan");
    v.field("joint_gate_probability", joint_gate_probability, Rule::open(0, 1), "joint gate of all pairings of a scan");
    v.field("new_landmark_squared_distance", new_landmark_squared_distance, Rule::not_negative(),
            "an unpaired observation becomes a landmark only when its squared Mahalanobis distance to every landmark exceeds this");
    v.field("node_budget", node_budget, Rule::at_least(1), "nodes of the search tree of one scan");
    v.field("identity_gate_probability", identity_gate_probability, Rule::open(0, 1),
            "with known identities, an observation outside this gate of its landmark is misread and dropped; without it all are believed");
  }
};

/// Which landmarks a scan could show, given how sure the filter is of its vehicle.
class ScanReach {
 public:
  ScanReach(const Features& scan, const Ekf& filter);
  /// Farthest possible distance from the estimated vehicle of a landmark whose position has covariance of this trace (m^2).
  [[nodiscard]] double radius_m(double position_variance) const;

 private:
  double farthest_m_ = 0.0;
  double sigma_range_m_ = 0.0;
  double vehicle_variance_ = 0.0;  ///< m^2
};

struct ScanAssociation {
  Hypothesis hypothesis;  ///< prediction j stands for landmark selected[j] of the filter
  std::vector<Eigen::Index> selected;
  std::vector<bool> is_paired;      ///< by observation
  std::vector<Eigen::Index> fresh;  ///< unpaired observations outside the dead band: new landmarks
  int wrong_pairs = 0;              ///< pairs whose source identities differ, where both are known
  double time_s = 0.0;
};

class ScanAssociator {
 public:
  ScanAssociator(const ScanAssociationConfig& config, std::uint64_t seed);

  /// landmarks: in the order of the filter's. The answer is kept until the next call.
  const ScanAssociation& associate(const Features& scan, Ekf& filter, const std::vector<MapLandmark>& landmarks);

 private:
  void pair_by_identity(const Features& scan, Ekf& filter, const std::vector<MapLandmark>& landmarks);
  void pose_problem(const Features& scan, Ekf& filter);  ///< fills problem_ for scan against the selected landmarks
  void preselect(const Features& scan, const Ekf& filter);

  ScanAssociationConfig config_;
  Rng rng_;
  std::optional<double> identity_gate_;  ///< chi-squared, 2 degrees of freedom
  PairingProblem problem_;
  ScanAssociation answer_;
};

}  // namespace ssjs
