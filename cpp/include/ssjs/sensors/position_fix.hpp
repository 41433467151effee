/// A position in the world from outside: satellites at the surface, or the word of an operator. docs/math/ports.md (P-30).
#pragma once

#include <Eigen/Core>

#include "ssjs/base/archive.hpp"

namespace ssjs {

struct PositionFix {
  Eigen::Vector2d world_p_vehicle = Eigen::Vector2d::Zero();  ///< m, world frame
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();   ///< m^2, positive definite
  bool set_pose = false;                                      ///< believed whatever was expected: an operator said so (P-33)

  void archive(Archive& a) {
    a("world_p_vehicle", world_p_vehicle);
    a("covariance", covariance);
    a("set_pose", set_pose);
  }
};

}  // namespace ssjs
