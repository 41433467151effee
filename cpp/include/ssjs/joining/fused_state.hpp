/// The state of the map that two fused ones make. docs/math/ssjs.md (J-11, J-12).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/joining/fusion_solution.hpp"

namespace ssjs {

/// y = g(x_a, x_b, tau): [a's poses | b's base where a does not know it | b's other poses | a's landmarks | b's unpaired
/// landmarks], all that is b's moved by tau (J-12).
class FusedState {
 public:
  FusedState(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs);

  void name_contents(LiveMap& map) const;

  /// G diag(P_a, P_b) G' - (G Y)(G Y)' + E C E' with E = G D + dg/dtau: (J-11) and (J-12) in one.
  void estimate(const FusionConstraints& constraints, const FusionSolution& solution, LiveMap& map) const;

 private:
  struct Kept {
    Eigen::Index index;      ///< among b's poses or landmarks
    Eigen::Index row;        ///< of the fused state
    Eigen::Index component;  ///< of b's state
  };

  /// G diag(P_a, P_b) G', lower triangle.
  [[nodiscard]] Eigen::MatrixXd prior_covariance(const Eigen::Matrix2d& R) const;

  const LiveMap& a_;
  const LiveMap& b_;
  Eigen::Index a_poses_, a_landmarks_;  ///< numbers of the state
  bool keeps_b_base_;
  std::vector<Kept> poses_, landmarks_;  ///< of b
  Eigen::Index first_a_landmark_ = 0, size_ = 0;
};

}  // namespace ssjs
