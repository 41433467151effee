/// Remembers what the filter did inside one submap, so that every past pose can be conditioned on the exit pose when the
/// submap closes. docs/math/submaps.md (C-3, C-4).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/filter/ekf.hpp"
#include "ssjs/mapping/submap.hpp"

namespace ssjs {

class TrajectoryJournal {
 public:
  void clear();
  void step(double time_s, const Se2& base_T_vehicle, const Eigen::Matrix3d& covariance);

  /// The steps with their gain on the exit pose, whose covariance is given.
  [[nodiscard]] std::vector<SubmapStep> steps(const GaussianSe2& base_T_exit) const;

 private:
  std::vector<SubmapStep> steps_;
};

}  // namespace ssjs
