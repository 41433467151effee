/// The way along the levelled maps of a survey, from map to map by exits and compass alone: what loop closures are judged by, because no
/// closure is in it. docs/math/closures.md (C-1, C-2).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/mapping/levelled_submap.hpp"

namespace ssjs {

/// A stretch of the way, which is a map again (C-1): exit t (3: x m, y m, heading rad), compass entries c_s, c_e (2, rad, or none) and any
/// further entries of its first map, with their joint covariance (additive coordinates), all in the frame of its first base.
struct Stretch {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  Eigen::Index compass_rows = 0;  ///< 2 or 0

  [[nodiscard]] Se2 first_T_last() const { return Se2::from_vector(mean.head<3>()); }
  [[nodiscard]] Eigen::Index extra() const { return 3 + compass_rows; }  ///< row of the first further entry
};

/// a, then b, which starts where a ends; b has no further entries. Where the compass goes on, the offset that a ended with is the one that
/// b started with (C-2).
[[nodiscard]] Stretch followed_by(const Stretch& a, const Stretch& b, bool compass_goes_on);

class LevelledChain {
 public:
  /// The next map. compass_goes_on: whether its compass offset at the start is the one that the map before ended with; drift_variance: by
  /// which (rad^2) a map's one mean offset may differ from that of the map before.
  void append(const LevelledSubmap& submap, bool compass_goes_on, double drift_variance);

  [[nodiscard]] int maps() const { return static_cast<int>(goes_on_.size()); }
  /// From base `from` to base `to`, 0 <= from <= to <= maps(), with further entries (`rows`, none of them an angle) of the map `first` that
  /// starts at `from`. O(log(to - from)).
  [[nodiscard]] Stretch between(int from, int to, const LevelledSubmap& first, const std::vector<Eigen::Index>& rows) const;

 private:
  std::vector<bool> goes_on_;                 ///< by map: the compass, at its start
  std::vector<double> drift_;                 ///< by map
  std::vector<std::vector<Stretch>> blocks_;  ///< [level][block]: 2^level maps each
};

}  // namespace ssjs
