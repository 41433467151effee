/// Selective submap joining (SSJS): two maps are fused only when they share enough landmarks. Thesis 3.3, Algorithm 3,
/// in a form that uses every measurement exactly once: docs/math/ssjs.md.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/base_estimate.hpp"
#include "ssjs/joining/global_map.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/map_association.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/mapping/submap_builder.hpp"

namespace ssjs {

struct SelectiveJoinerConfig {
  double fusion_threshold = 0.3;
  int min_pairs = 3;
  int min_gap = 1;
  int max_fused_landmarks = 60;
  std::optional<double> max_pairing_sigma_m = 1.5;
  double gate_probability = 0.99;
  double joint_gate_probability = 0.95;
  double fusion_probability = 0.99;
  int node_budget = 1500;
  GlobalSolver solver = GlobalSolver::kInvariantEkf;
  int dense_bases = 350;
  int max_ports = 16;
  int min_shared_bases = 2;
  int max_inner_poses = 40;
  bool final_adjustment = true;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("fusion_threshold", fusion_threshold, Rule::closed(0, 1),
            "two maps are fused when they share this fraction of the newer submap's landmarks");
    v.field("min_pairs", min_pairs, Rule::at_least(2), "... and at least so many landmarks");
    v.field("min_gap", min_gap, Rule::at_least(1), "submaps at most this many apart in time are not compared");
    v.field("max_fused_landmarks", max_fused_landmarks, Rule::at_least(3), "a fused map holds at most so many landmarks");
    v.field("max_pairing_sigma_m", max_pairing_sigma_m, Rule::positive(),
            "pairings of maps whose relative position is less sure than this are refused as ambiguous (about 0.16 of the landmark spacing "
            "on a lattice, "
            "0.3 in an irregular field)");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing between maps");
    v.field("joint_gate_probability", joint_gate_probability, Rule::open(0, 1), "joint gate of all pairings between two maps");
    v.field("fusion_probability", fusion_probability, Rule::open(0, 1), "a fusion whose chi-squared exceeds this quantile is refused");
    v.field("node_budget", node_budget, Rule::at_least(1), "nodes of the search tree of one pair of maps");
    v.choice("solver", solver, Choices<GlobalSolver>{{"ekf", GlobalSolver::kInvariantEkf}, {"gauss-newton", GlobalSolver::kGaussNewton}},
             "global update: one invariant EKF step a fusion, or sparse Gauss-Newton over the port factors");
    v.field("dense_bases", dense_bases, Rule::at_least(2),
            "above so many live bases the EKF's dense covariance gives way to sparse port factors where those are cheaper");
    v.field("max_ports", max_ports, Rule::at_least(2),
            "a fused map drops its least sure ports beyond this number, so that visiting an area again and again stays cheap");
    v.field("min_shared_bases", min_shared_bases, Rule::at_least(2),
            "thinning leaves two maps at least so many common base frames, the surest");
    v.field("max_inner_poses", max_inner_poses, Rule::at_least(0),
            "a fused map keeps so many inner base frames in its state; older ones are frozen in its frame");
    v.field("final_adjustment", final_adjustment, "Gauss-Newton over all port factors at the end of the mission");
  }
};

class SelectiveJoiner final : public MapJoiner {
 public:
  SelectiveJoiner(const SelectiveJoinerConfig& config, AssociationMethod association, std::optional<int> max_submap_landmarks,
                  std::uint64_t seed);

  [[nodiscard]] JoinReport take(const Submap& submap) override;
  [[nodiscard]] GaussianSe2 global_T_newest_base() const override;
  JoinReport finish() override;
  [[nodiscard]] WorldEstimate estimate(BaseCovariance covariance) const override;

  [[nodiscard]] const GlobalMap& global() const { return global_; }
  [[nodiscard]] const std::map<int, LiveMap>& maps() const { return maps_; }

 private:
  [[nodiscard]] std::vector<int> candidates_for(const LiveMap& fresh) const;
  /// Landmarks of b that are landmarks of a, for unknown identities; reach_m as in overlap(). Not sought, with the reason in `attempt`,
  /// where the maps could not be fused whatever they are.
  [[nodiscard]] std::vector<Pair> search_pairs(const LiveMap& a, const LiveMap& b, double reach_m, int needed, LoopAttempt& attempt,
                                               JoinReport& report);
  [[nodiscard]] std::vector<Pair> common_landmarks_of(const LiveMap& a, const LiveMap& b) const;  ///< by the present estimate
  /// Compares the map at base `b` with the one at base `a`; fuses them when they share enough. True when fused (into base a).
  bool compare(int a, int b, int needed, LoopAttempt& attempt, JoinReport& report);

  void replace_users(const LiveMap& map, int change);
  [[nodiscard]] std::vector<bool> ports_of(const LiveMap& map) const;
  /// With more than max_ports ports, drops the bases that `fused` shares with other maps beyond min_shared_bases (J-19); returns the maps
  /// that now hold one alone.
  [[nodiscard]] std::vector<int> loosen_ties(LiveMap& fused);
  void freeze_inner_poses(LiveMap& fused);

  SelectiveJoinerConfig config_;
  MapAssociator associator_;
  std::optional<int> max_submap_landmarks_;
  GlobalMap global_;
  std::map<int, LiveMap> maps_;  ///< live, by base
  std::map<int, int> users_;     ///< by base: how many live maps hold it, as their own or as a pose
  std::vector<FrozenBase> frozen_;
  int newest_base_ = 0;
};

}  // namespace ssjs
