/// The way between the ends of one or two closures with everything that the closures touch, as one small Gaussian; and the closures as
/// constraints on it. docs/math/closures.md (C-3..C-5).
#pragma once

#include <Eigen/Core>
#include <deque>
#include <map>
#include <vector>

#include "ssjs/joining/closure.hpp"

namespace ssjs {

class ClosureProblem {
 public:
  ClosureProblem(const std::vector<const Closure*>& closures, const LevelledChain& chain, const std::deque<PortMap>& maps);

  /// The state: for every base at which a closure ends, ascending, the pose of the next one in its frame (not for the last), and then the
  /// landmarks (x, y) of its map that closures name.
  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }
  [[nodiscard]] const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// What closure `nth` is off by at a state, its Jacobian over the state, and the noise of its own (C-4).
  struct Residual {
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    Eigen::MatrixXd noise;
  };
  [[nodiscard]] Residual residual(std::size_t nth, const Eigen::VectorXd& state) const;
  /// Metres of residual(nth, state): of a pose, or root mean square of the pairs.
  [[nodiscard]] double off_m(std::size_t nth, const Eigen::VectorXd& state) const;

  /// The most likely state where these closures hold, and its squared distance from mean() (C-5).
  struct Solution {
    Eigen::VectorXd state;
    double chi_squared = 0.0;
  };
  [[nodiscard]] Solution solve(const std::vector<std::size_t>& closures) const;

 private:
  [[nodiscard]] Residual stacked(const std::vector<std::size_t>& closures, const Eigen::VectorXd& state) const;

  std::vector<const Closure*> closures_;
  std::vector<int> bases_;                                         ///< ascending
  std::vector<Eigen::Index> pose_;                                 ///< by place in bases_: row of the pose of the next one
  std::map<std::pair<int, Eigen::Index>, Eigen::Index> landmark_;  ///< by map and landmark: row
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
};

}  // namespace ssjs
