/// Joins the levelled maps of an underwater survey by their ports: bases, compass offsets, landmarks seen again. Nothing is fused, every
/// measurement stays in its map. docs/math/ports.md.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/closure_guard.hpp"
#include "ssjs/joining/map_joiner.hpp"
#include "ssjs/joining/port_association.hpp"
#include "ssjs/joining/port_duplicates.hpp"
#include "ssjs/joining/port_fixes.hpp"
#include "ssjs/joining/port_level.hpp"
#include "ssjs/joining/port_reach.hpp"
#include "ssjs/mapping/scan_association.hpp"

namespace ssjs {

enum class PortSolver { kBatch, kRecursive };

struct PortJoinerConfig {
  PortSolver solver = PortSolver::kBatch;
  double relinearize_heading_rad = 0.01;
  AssociationMethod association = AssociationMethod::kJointCompatibility;  ///< set by the pipeline: as within the maps
  double gate_probability = 0.99;
  double joint_gate_probability = 0.95;
  int node_budget = 1500;
  double max_chance_odds = 0.3;
  std::optional<double> max_chance_alignments;
  double max_descriptor_distance = PortAssociationConfig{}.max_descriptor_distance;
  double duplicate_probability = DuplicateConfig{}.duplicate_probability;
  std::optional<double> north_offset_rad;
  double north_offset_sigma_rad = 0.05;
  double offset_drift_rad_per_sqrt_s = 0.0;
  FixConfig fixes;
  ClosureGuardConfig closures;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("solver", solver, Choices<PortSolver>{{"batch", PortSolver::kBatch}, {"recursive", PortSolver::kRecursive}},
             "global level: sparse Gauss-Newton over all maps, or an extended Kalman filter over their ports");
    v.field("relinearize_heading_rad", relinearize_heading_rad, Rule::positive(),
            "recursive: a base that turned by more than this starts the filter anew from Gauss-Newton");
    v.field("gate_probability", gate_probability, Rule::open(0, 1), "individual gate of a pairing between maps, in the plane and in depth");
    v.field("joint_gate_probability", joint_gate_probability, Rule::open(0, 1), "joint gate of all pairings of a map");
    v.field("node_budget", node_budget, Rule::at_least(1), "nodes of the search tree of one map");
    v.field("max_chance_odds", max_chance_odds, Rule::positive(),
            "a pair is refused when, given the other pairs, it is so likely to be a foreign landmark, relative to the same one");
    v.field(
        "max_chance_alignments", max_chance_alignments, Rule::positive(),
        "pairs that lay a map over earlier ones are refused when so many alignments as good are to be expected among foreign landmarks; "
        "without it each pair is judged by itself");
    v.field("max_descriptor_distance", max_descriptor_distance, Rule::positive(),
            "landmarks of a camera whose descriptors point farther apart are not one (0 alike, 1.41 nothing in common)");
    v.field("duplicate_probability", duplicate_probability, Rule{0, 1, false, true},
            "how likely a landmark is to be known a second time, under another number; such pairs are merged; 0: nothing is merged");
    v.field(
        "north_offset_rad", north_offset_rad, Rule::any(),
        "aligns the world to north: the expected compass reading minus the true heading (minus the declination); without it the world is "
        "that of the first base");
    v.field("north_offset_sigma_rad", north_offset_sigma_rad, Rule::positive(), "... and its standard deviation");
    v.field("offset_drift_rad_per_sqrt_s", offset_drift_rad_per_sqrt_s, Rule::not_negative(),
            "random walk of the compass offset between maps that state their mean offset only; 0 takes it for constant");
    v.section("fixes", fixes, "position fixes, such as on surfacing");
    v.section("closures", closures, "loop closures that contradict each other");
  }
};

class PortJoiner {
 public:
  explicit PortJoiner(const PortJoinerConfig& config);

  /// Before the first map, for maps that are no chain: base k stands at entry k - 1, and how surely, by itself (W-1). Their maps are
  /// number 1 and on, number 0 being this datum; where they end is not asked. Such a joiner cannot be archived.
  void stand_on(const std::vector<GaussianSe2>& world_T_base);
  /// Takes map number k, which starts at base k and ends at base k + 1. Throws InvalidArgument when it is not the next one, its shapes do
  /// not fit, or it knows another kind of compass ports than the maps before. Of a map that is not sound nothing is believed (P-40).
  JoinReport take(LevelledSubmap submap);
  /// Loop closures that something else claims, between bases that are there (the newest one included). Those that contradict others that
  /// agree are refused with the reason; so are earlier ones, later, when more agree against them. docs/math/closures.md. Throws
  /// InvalidArgument on a closure that is none.
  JoinReport propose(const std::vector<Closure>& closures);
  /// Gauss-Newton over everything: the best estimate there is. Landmarks that are known twice by now are merged.
  JoinReport finish();

  [[nodiscard]] const std::deque<PortMap>& maps() const { return maps_; }
  [[nodiscard]] const PortLevel& level() const { return *level_; }
  [[nodiscard]] const ClosureGuard& closures() const { return guard_; }
  [[nodiscard]] GaussianSe2 global_T_newest_base() const;
  /// Borders at which the compass offset was not what the map before had: it jumped, or its first reading in the map was wrong.
  [[nodiscard]] int compass_jumps() const { return compass_jumps_; }
  /// Landmarks that were found to be another one, and how many of those differ in their source identities, where both are known.
  [[nodiscard]] int merged() const { return merged_; }
  [[nodiscard]] int wrongly_merged() const { return wrongly_merged_; }

 private:
  /// Landmark `own` of the map in question is landmark `other` of another.
  struct Match {
    Eigen::Index own;
    Sighting other;
  };

  /// What ties the level together beyond the way, in the order in which it was found: the source from which the level can be built anew.
  struct Tie {
    enum class Kind : std::uint8_t { kJoin, kUnite, kPose };
    Kind kind = Kind::kJoin;
    int newest = 0;  ///< map when it was found
    int batch = 0;   ///< those of one batch are tied at once
    int map = 0;
    Eigen::Index entry = 0;                ///< landmark of `map`; row of a pose
    int other = 0;                         ///< map; base of a pose
    Eigen::Index landmark = 0;             ///< of `other`
    std::optional<std::size_t> closure{};  ///< that it is part of; none: a landmark known twice
    bool wrong = false;                    ///< landmarks of different source identities

    void archive(Archive& a) {
      a.choice("kind", kind, Kind::kPose);
      a("newest", newest);
      a("batch", batch);
      a("map", map);
      a("entry", entry);
      a("other", other);
      a("landmark", landmark);
      a("closure", closure);
      a("wrong", wrong);
    }
  };

  [[nodiscard]] static std::unique_ptr<PortLevel> make_level(const PortJoinerConfig& config);
  void check(const LevelledSubmap& submap) const;
  void attach(PortMap& map);
  [[nodiscard]] bool offset_goes_on(const PortMap& map) const;
  [[nodiscard]] int offset_at_start(const PortMap& map) const;
  [[nodiscard]] bool offset_is_shared() const;

  [[nodiscard]] std::vector<Match> match_by_identity(int newest) const;
  JoinReport pair_with(int observer, const std::vector<int>& others, bool only_ports);
  void join(int observer, const std::vector<Match>& matches);
  void tie(int observer, const std::vector<Match>& matches);
  void unite(Sighting a, Sighting b);
  [[nodiscard]] PortMap& map_at(int base) { return maps_[static_cast<std::size_t>(base)]; }

  void check(const Closure& closure) const;
  [[nodiscard]] std::vector<Match> standing(int observer, const std::vector<Match>& matches, LoopAttempt& attempt);
  [[nodiscard]] bool holds(const Tie& tie) const { return !tie.closure || in_force_[*tie.closure]; }
  [[nodiscard]] LoopAttempt attempt_of(std::size_t closure);
  void put_in_force(const Tie& tie);
  [[nodiscard]] std::optional<ClosureFit> against_the_rest(std::size_t closure) const;
  void judge_by_the_rest(const std::vector<std::size_t>& closures, JoinReport& report);
  void revise(JoinReport& report);
  void rebuild();
  void chain_anew();
  void merge_duplicates(const std::vector<int>& among);
  void merge(const Duplicate& duplicate);
  [[nodiscard]] double density_around(int observer, const std::vector<Sighting>& predicted) const;

  PortJoinerConfig config_;
  PortAssociationConfig association_;
  std::unique_ptr<PortLevel> level_;
  PortFixes fixes_;
  std::deque<PortMap> maps_;
  PortReach reach_;
  std::map<std::int64_t, Sighting> first_seen_;  ///< by source identity; valid with known association
  std::optional<CompassPorts> compass_;          ///< of all maps
  bool compass_is_mean_ = false;
  bool bases_are_given_ = false;  ///< stand_on() was called: the maps are no chain
  double last_mean_time_s_ = 0.0;
  int landmark_ports_ = 0;
  int compass_jumps_ = 0;
  int merged_ = 0, wrongly_merged_ = 0;
  std::deque<bool> compass_goes_on_;    ///< by map, at its start
  std::vector<double> drift_variance_;  ///< by map: of its mean offset since the map before
  ClosureGuard guard_;
  std::vector<Tie> ties_;
  std::deque<bool> in_force_;  ///< by closure of the guard: whether the level holds it
  int batches_ = 0;

 public:
  /// Reads into a new joiner.
  void archive(Archive& a);

 private:
  void check_read() const;
  void check_ties() const;
};

}  // namespace ssjs
