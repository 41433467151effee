/// What a joining method of the literature does with finished submaps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ssjs/base/archive.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

/// One attempt to tie two maps that are not neighbours in time.
struct LoopAttempt {
  double time_s = 0.0;
  int from = 0;  ///< the submap just finished
  int to = 0;    ///< base of the map it was compared with
  bool accepted = false;
  std::string reason;  ///< why not; empty when accepted
  int pairs = 0;
  std::optional<int> wrong_pairs;  ///< pairs whose source identities differ, where all are known
  std::optional<double> chi_squared;
  int dof = 0;
  double sigma_m = 0.0;  ///< uncertainty of the pairing before the decision
  std::string source{};  ///< who proposed it; empty: the joiner's own pairing
  bool revised = false;  ///< an earlier decision about this closure is taken back

  void archive(Archive& a) {
    a("time_s", time_s);
    a("from", from);
    a("to", to);
    a("accepted", accepted);
    a("reason", reason);
    a("pairs", pairs);
    a("wrong_pairs", wrong_pairs);
    a("chi_squared", chi_squared);
    a("dof", dof);
    a("sigma_m", sigma_m);
    a("source", source);
    a("revised", revised);
  }
};

/// Two maps merged that follow each other in time, or one map associated with itself.
struct NeighbourJoin {
  int from = 0, to = 0;            ///< their bases
  int pairs = 0;                   ///< landmarks found in both, or found twice
  std::optional<int> wrong_pairs;  ///< as in LoopAttempt
  double chi_squared = 0.0;
  int dof = 0;

  void archive(Archive& a) {
    a("from", from);
    a("to", to);
    a("pairs", pairs);
    a("wrong_pairs", wrong_pairs);
    a("chi_squared", chi_squared);
    a("dof", dof);
  }
};

/// A position fix held against the survey. docs/math/ports.md (P-30..P-33).
struct FixAttempt {
  double time_s = 0.0;
  int base = 0;
  bool accepted = false;
  bool relocated = false;             ///< the estimate was found wrong: this fix and the refused ones before it are used
  std::string reason;                 ///< why not; empty when accepted
  std::optional<double> chi_squared;  ///< of 2; nothing of the first fix, which decides where the survey lies
  double distance_m = 0.0;            ///< from where the survey expected the vehicle

  void archive(Archive& a) {
    a("time_s", time_s);
    a("base", base);
    a("accepted", accepted);
    a("relocated", relocated);
    a("reason", reason);
    a("chi_squared", chi_squared);
    a("distance_m", distance_m);
  }
};

struct JoinReport {
  int candidates = 0;              ///< pairs of maps compared
  std::vector<LoopAttempt> loops;  ///< compared pairs, in the order of the comparison
  std::vector<NeighbourJoin> neighbours;
  int fusions = 0;  ///< two maps became one, whether neighbours or a loop
  double association_time_s = 0.0;
  bool budget_exhausted = false;
  std::vector<FixAttempt> fixes{};
  int unsound = 0;  ///< maps of which nothing was believed

  void append(const JoinReport& later);
  /// All but the time it took.
  void archive(Archive& a) {
    a("candidates", candidates);
    a("loops", loops);
    a("neighbours", neighbours);
    a("fusions", fusions);
    a("budget_exhausted", budget_exhausted);
    a("fixes", fixes);
    a("unsound", unsound);
  }
};

struct LandmarkEstimate {
  GaussianPoint2 position;  ///< world frame
  MapLandmark landmark;
  int base = 0;  ///< of the map that holds it
};

struct LiveMapEstimate {
  int base = 0;
  std::vector<int> members;
  int landmarks = 0;
};

/// The joint covariance of all bases is dense: it grows with the square of the mission.
enum class BaseCovariance { kBorders, kJoint };

/// Everything a method knows at one moment, in the world frame.
struct WorldEstimate {
  std::vector<Se2> global_T_base;           ///< by base index: base k is where submap k starts, the last one is the present border
  std::vector<Matrix6d> border_covariance;  ///< one a submap: of its bases k and k + 1 together, additive coordinates
  Eigen::MatrixXd base_covariance;          ///< of all bases together, 3 each; empty unless asked for and known to the method
  std::vector<LandmarkEstimate> landmarks;
  std::vector<LiveMapEstimate> maps;
};

/// A joining method takes finished submaps one after the other and answers where they are.
class MapJoiner {
 public:
  MapJoiner() = default;
  MapJoiner(const MapJoiner&) = delete;
  MapJoiner& operator=(const MapJoiner&) = delete;
  virtual ~MapJoiner() = default;

  /// Takes submap number k (starting at base k); its exit pose is base k + 1.
  [[nodiscard]] virtual JoinReport take(const Submap& submap) = 0;

  /// Present estimate of the newest base, where the next submap starts.
  [[nodiscard]] virtual GaussianSe2 global_T_newest_base() const = 0;

  /// Called once after the last submap, before estimate(): the time for a last global adjustment, or the joins that are left.
  virtual JoinReport finish() = 0;

  [[nodiscard]] virtual WorldEstimate estimate(BaseCovariance covariance) const = 0;
};

}  // namespace ssjs
