/// The global level of a survey: bases, compass offsets and landmarks that several levelled maps share. Every map is a factor over its
/// ports. docs/math/ports.md (P-4, P-6..P-9, P-19).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "ssjs/joining/port_knowledge.hpp"

namespace ssjs {

/// What is known of a compass offset (compass reading minus true heading) beforehand: minus the magnetic declination, and how sure.
struct OffsetPrior {
  double mean_rad = 0.0;
  double variance = 0.0;  ///< rad^2, > 0

  void archive(Archive& a) {
    a("mean_rad", mean_rad);
    a("variance", variance);
  }
};

/// A fix of the vehicle at `base_p` of a base's frame. (P-30)
struct FixFactor {
  int base = 0;
  Eigen::Vector2d base_p = Eigen::Vector2d::Zero();          ///< m
  Eigen::Vector2d world_p = Eigen::Vector2d::Zero();         ///< m
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< m^2

  void archive(Archive& a) {
    a("base", base);
    a("base_p", base_p);
    a("world_p", world_p);
    a("covariance", covariance);
  }
};

/// Where a fix is expected, with the Jacobian over the base (x, y, heading). (P-30)
struct PlacedFix {
  Eigen::Vector2d world_p;
  Eigen::Matrix<double, 2, 3> J_base;
};
[[nodiscard]] PlacedFix place_fix(const Se2& global_T_base, const Eigen::Vector2d& base_p);

/// What is known of base 0 where fixes tell where it is: nothing of its position; of its heading, where no offset prior does, that it is 0
/// give or take this. (P-31)
struct StartPrior {
  double heading_variance = 0.0;  ///< rad^2, > 0

  void archive(Archive& a) { a("heading_variance", heading_variance); }
};

/// Base 0 stands at the origin, or where fixes put it. Its heading is 0 (the world is aligned to it), or, with an offset prior, free: then
/// the world's x axis is where the prior's headings start from, north. Two implementations: BatchPorts and RecursivePorts. Both take the
/// same calls in the same order, an unknown's index being the next of its kind; the caller puts the ports into the map AFTER the call.
class PortLevel : public PortKnowledge {
 public:
  /// North-aligned world: offset 0 has this prior, and base 0 its heading from the compass entry (`row`) of map 0. Before anything else.
  virtual void align_to_north(const PortMap& map, Eigen::Index row, const OffsetPrior& prior) = 0;
  /// Each port's unknown is new and gets its value from the map (P-7). All together, so that cross terms are kept.
  virtual void introduce(const PortMap& map, const std::vector<Port>& ports) = 0;
  /// Each port's unknown is known already: what the map says of it is a new measurement (P-8).
  virtual void tie(const PortMap& map, const std::vector<Port>& ports) = 0;
  /// A new offset: that of index `from` plus a random walk of this variance (P-4).
  virtual void drift(int from, double variance) = 0;
  /// Two landmarks are one (P-19): what the maps say of `gone` they say of `keep` from now on. `gone` keeps its index, is held fixed and
  /// is not to be asked for. The caller renames the ports of the maps AFTER the call.
  virtual void merge_landmarks(int keep, int gone) = 0;
  /// Base 0 is free from now on. Followed by fix() before anything else; a second call changes nothing.
  virtual void free_start(const StartPrior& prior) = 0;
  virtual void fix(const FixFactor& fix) = 0;
  /// The covariance of the map has changed: its factor is made anew. (P-33)
  virtual void loosen(const PortMap& map) = 0;
  /// Best estimate of all that was told so far; covariance() and values() answer for it.
  virtual void settle() = 0;
  /// Gauss-Newton over everything, whatever the implementation.
  virtual void adjust() = 0;

  /// What does not follow from the maps and their ports ...
  virtual void archive(Archive& a) = 0;
  /// ... and what does, once that and the maps were read.
  virtual void resume(const std::deque<PortMap>& maps) = 0;
};

/// Appends to `values` what `map` says of the ports' unknowns, which are the next of their kinds (P-7).
void append_values(PortValues& values, const PortMap& map, const std::vector<Port>& ports);

}  // namespace ssjs
