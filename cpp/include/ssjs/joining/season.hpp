/// Missions over the same ground as maps of one world: what they saw in common ties their frames, and is one contact.
/// docs/math/season.md (W-1..W-4).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/base/progress.hpp"
#include "ssjs/joining/port_joiner.hpp"

namespace ssjs {

/// A finished mission. Its landmarks are in its own frame, 3 rows each: x, y, absolute depth (m); errors of different missions are
/// independent.
struct MissionMap {
  GaussianSe2 world_T_mission;  ///< from its origin alone, additive covariance
  Eigen::VectorXd mean;         ///< 3n
  Eigen::MatrixXd covariance;   ///< 3n x 3n, of all of them together
};

struct SeasonConfig {
  double gate_probability = PortJoinerConfig{}.gate_probability;
  double joint_gate_probability = PortJoinerConfig{}.joint_gate_probability;
  int node_budget = 10000;
  double max_chance_odds = PortJoinerConfig{}.max_chance_odds;
  double max_chance_alignments = 0.1;
  double duplicate_probability = PortJoinerConfig{}.duplicate_probability;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing between missions, plane and depth");
    v.field("joint_gate_probability", joint_gate_probability, Rule::open(0, 1), "joint gate of all pairings of a mission");
    v.field("node_budget", node_budget, Rule::at_least(1), "nodes of the search tree of one mission");
    v.field("max_chance_odds", max_chance_odds, Rule::positive(), "odds of chance from which on a pair of two missions is refused");
    v.field("max_chance_alignments", max_chance_alignments, Rule::positive(),
            "the pairs of a mission are refused when so many alignments as good are to be expected by chance");
    v.field("duplicate_probability", duplicate_probability, Rule{0, 1, false, true},
            "how likely a contact of the season is to be known a second time; 0: nothing is merged afterwards");
  }
};

/// Landmark `landmark` of mission `mission`, places in what was given.
struct MissionLandmark {
  std::size_t mission;
  std::size_t landmark;
};

struct SeasonContact {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world frame, m; z depth
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<MissionLandmark> sightings;  ///< ascending by mission; at most one of a mission
};

struct SeasonEstimate {
  std::vector<GaussianSe2> world_T_mission;  ///< by mission, by all that was found in common
  std::vector<int> sites;                    ///< by mission: those of one number lie, or might lie, over each other
  std::vector<SeasonContact> contacts;       ///< by their first sightings
  int budget_exhausted = 0;                  ///< missions whose pairing was the best found so far, not the best
};

/// Missions that might overlap by their origins (W-2) are joined in the order given, each against all before (W-3); others do not meet.
/// Throws InvalidArgument naming the mission whose shapes do not fit, Cancelled when the sink says so.
[[nodiscard]] SeasonEstimate join_missions(const std::vector<MissionMap>& missions, const SeasonConfig& config,
                                           const ProgressSink& progress = {});

}  // namespace ssjs
