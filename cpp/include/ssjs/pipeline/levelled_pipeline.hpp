/// The whole of SLAM for an underwater vehicle, fed one tick at a time: levelled maps, tied by their ports. docs/math/auv.md, ports.md.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/config_field.hpp"
#include "ssjs/joining/divide_and_conquer.hpp"
#include "ssjs/joining/landmark_existence.hpp"
#include "ssjs/joining/port_joiner.hpp"
#include "ssjs/joining/selective.hpp"
#include "ssjs/joining/survey_joiner.hpp"
#include "ssjs/mapping/levelled_builder.hpp"
#include "ssjs/pipeline/dead_reckoning.hpp"
#include "ssjs/pipeline/sensor_guard.hpp"

namespace ssjs {

enum class LevelledMethod {
  kPorts,         ///< selective joining: independent maps, tied where they share landmarks
  kOneMap,        ///< plain EKF: the same filter with a single map that never ends
  kNaiveHeading,  ///< kPorts over maps whose compass is taken for exact once its first reading is taken off
  // The methods for vehicles in the plane, over the planar marginals of the same maps. docs/math/underwater_methods.md
  kFused,  ///< selective joining that fuses maps
  kSelectiveThesis,
  kSequential,
  kDivideAndConquer,
  kHierarchical,
  kConstrainedLocal,
};

struct LevelledConfig {
  LevelledMethod method = LevelledMethod::kPorts;
  LevelledBuilderConfig local;
  PortJoinerConfig joining;
  SelectiveJoinerConfig fusing;
  DivideAndConquerConfig dcs;
  ExistenceConfig existence;
  GuardConfig guard;
  /// Those of every field, and what does not fit together.
  [[nodiscard]] std::vector<std::string> violations() const;
  template <class Visitor>
  void visit(Visitor& v) {
    v.choice("method", method,
             Choices<LevelledMethod>{{"ssjs", LevelledMethod::kPorts},
                                     {"ekf", LevelledMethod::kOneMap},
                                     {"lmj", LevelledMethod::kSequential},
                                     {"dcs", LevelledMethod::kDivideAndConquer},
                                     {"hs", LevelledMethod::kHierarchical},
                                     {"clsf", LevelledMethod::kConstrainedLocal},
                                     {"ssjs-fused", LevelledMethod::kFused},
                                     {"ssjs-thesis", LevelledMethod::kSelectiveThesis},
                                     {"ssjs-naive-heading", LevelledMethod::kNaiveHeading}},
             "ssjs: submaps tied by the landmarks and compass offsets they share; ekf: one map for the whole mission; over the submaps' "
             "planar marginals: joined in sequence (lmj), by divide and conquer (dcs), tied by their links alone (hs), constrained to a "
             "global map (clsf), selectively fused (ssjs-fused), so as printed in the thesis (ssjs-thesis); ssjs-naive-heading: ssjs with "
             "each submap's first compass reading taken for exact (overconfident, for comparison)");
    local.visit(v);
    v.section("joining", joining, "how submaps are tied to each other");
    v.section("fusing", fusing, "how the planar methods join submaps");
    v.section("dcs", dcs, "divide and conquer");
    v.section("existence", existence, "which landmarks are objects: how often the sonar passed them and how often they showed");
    v.section("guard", guard, "samples that no such vehicle can give");
  }
};

/// What one tick did.
struct LevelledReport {
  SurveyStep vehicle;  ///< the online estimate after the tick
  int submap = 0;
  bool remembered = false;  ///< the final trajectory will have a step at this tick
  UpdateResult update;
  int refused = 0;  ///< samples outside their gates
  int observations = 0;
  int wrong_pairs = 0;
  std::vector<FrameSighting> frame;  ///< of the landmarks that a camera frame showed
  std::optional<JoinReport> join;    ///< when the tick closed a submap
  double global_time_s = 0.0;        ///< wall time in the joining layer, without association
  double association_time_s = 0.0;
};

class LevelledPipeline {
 public:
  /// Throws InvalidArgument listing every violation of the configuration.
  explicit LevelledPipeline(const LevelledConfig& config, std::uint64_t seed = 1);

  /// Times must not decrease and values must be finite: otherwise InvalidArgument.
  LevelledReport feed(const NavigationTick& arrived);

  [[nodiscard]] SurveyStep global_T_vehicle() const;
  [[nodiscard]] const Se3& dead_reckoning() const { return dead_reckoning_.start_T_vehicle(); }

  /// Closes the last submap and lets the joining layer settle. No tick may follow.
  JoinReport finish();

  [[nodiscard]] const std::deque<PortMap>& maps() const { return joiner_->maps(); }  ///< the finished ones
  /// After finish().
  [[nodiscard]] SurveyEstimate estimate(std::size_t max_joint_bases) const { return joiner_->estimate(max_joint_bases); }
  [[nodiscard]] int compass_jumps() const { return joiner_->compass_jumps(); }
  [[nodiscard]] int merged() const { return joiner_->merged(); }
  /// Refused are those outside their gates and those that the guard did not believe.
  [[nodiscard]] SensorStatistics statistics(NavigationSensor sensor) const;

 private:
  SensorGuard guard_;
  LevelledBuilder builder_;
  std::unique_ptr<SurveyJoiner> joiner_;
  DeadReckoning dead_reckoning_;
  PortJoinerConfig joining_;   ///< as given: where north is
  GaussianSe2 global_T_base_;  ///< of the map that is being built
  bool finished_ = false;
};

}  // namespace ssjs
