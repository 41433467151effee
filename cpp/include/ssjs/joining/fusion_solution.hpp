/// The relative pose of two maps and the correction of both, from their constraints alone. docs/math/ssjs.md (J-9, J-10).
#pragma once

#include <Eigen/Core>
#include <string>

#include "ssjs/joining/fusion_constraints.hpp"

namespace ssjs {

/// The last iteration for (x_a, x_b, tau) in factors (J-9..J-11): Cov(x) = blkdiag(P_a, P_b) - Y Y' + D C D', Cov(x, tau) = D C, with
/// Y = P H' L^-T and D = -Y L^-1 J.
struct FusionSolution {
  Se2 a_T_b;
  Eigen::Matrix2d R;     ///< where H was taken
  Eigen::VectorXd gain;  ///< x = prior - P H' gain
  Eigen::MatrixXd L;     ///< of H P H'
  Eigen::Matrix<double, Eigen::Dynamic, 3> LiJ;
  Eigen::Matrix3d C;  ///< of tau
  double chi_squared = 0.0;
};

/// Where to begin: from a shared base, otherwise from the matched landmarks. Throws NotPositiveDefinite where neither fixes it.
[[nodiscard]] Se2 initial_relative_pose(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs,
                                        const std::vector<SharedBase>& shared);

/// Leaves the constraints at the solution. Throws NotPositiveDefinite with `name`.
[[nodiscard]] FusionSolution solve_fusion(FusionConstraints& constraints, const Se2& start, const std::string& name);

}  // namespace ssjs
