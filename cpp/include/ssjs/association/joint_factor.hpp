/// The joint distance of a growing set of pairs: a Cholesky factor that gains one 2x2 block row per pair.
/// docs/math/association.md.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/association/hypothesis.hpp"

namespace ssjs {

/// What is left of a pair once the pairs in a JointFactor are accepted.
struct ConditionedPair {
  Pair pair;
  Eigen::Vector2d residual;    ///< conditional residual
  Eigen::Matrix2d covariance;  ///< its covariance, symmetric
  double squared_distance;     ///< what the joint distance grows by when this pair is accepted
};

/// The 2x2 blocks of one block row of L side by side: 2 x 2 capacity.
using BlockRow = Eigen::Ref<Eigen::Matrix2Xd, 0, Eigen::OuterStride<2>>;
using ConstBlockRow = Eigen::Ref<const Eigen::Matrix2Xd, 0, Eigen::OuterStride<2>>;

/// L with L L' = joint covariance of the residuals of the accepted pairs, together with y = L^-1 residual.
/// A candidate carries its own block row of L, which `condition` extends pair by pair; `push` appends it and `pop`
/// only forgets it, so a tree search never factorises anything twice. No call allocates except the constructor.
class JointFactor {
 public:
  /// Keeps a reference to `problem`, which has to outlive this object. `capacity` is the largest number of pairs.
  JointFactor(const PairingProblem& problem, Eigen::Index capacity);

  [[nodiscard]] Eigen::Index size() const { return size_; }
  [[nodiscard]] Eigen::Index capacity() const { return static_cast<Eigen::Index>(accepted_.size()); }
  [[nodiscard]] const Pair& pair(Eigen::Index level) const { return accepted_[static_cast<std::size_t>(level)].pair; }
  /// Joint Mahalanobis distance squared of the accepted pairs, 2 * size() degrees of freedom.
  [[nodiscard]] double squared_distance() const;

  /// Residual and covariance before anything is accepted. Throws NotPositiveDefinite.
  [[nodiscard]] ConditionedPair start(const Pair& pair) const;
  /// Conditions a candidate, already conditioned on the pairs below `level`, on the accepted pair at `level`, and writes
  /// that block of its row. Throws NotPositiveDefinite naming the pair.
  void condition(ConditionedPair& candidate, BlockRow row, Eigen::Index level) const;
  /// Accepts a candidate that is conditioned on all size() pairs; `row` is the block row written by `condition`.
  void push(const ConditionedPair& candidate, const ConstBlockRow& row);
  void pop() { --size_; }

 private:
  struct Accepted {
    Pair pair;
    Eigen::Matrix2d inverse_diagonal;  ///< of the diagonal block of L, lower triangular
    Eigen::Vector2d y;
    double squared_distance;  ///< of this pair and all before it
  };

  [[nodiscard]] Eigen::Index row_start(Eigen::Index level) const { return level * (level - 1); }  // 2 (0 + 1 + .. + level-1)

  const PairingProblem& problem_;
  std::vector<Accepted> accepted_;
  Eigen::Matrix2Xd rows_;  ///< strictly lower block rows of L, one after the other
  Eigen::Index size_ = 0;
};

/// Joint Mahalanobis distance squared of all pairs together; 0 for none. Throws NotPositiveDefinite.
[[nodiscard]] double joint_squared_distance(const PairingProblem& problem, const std::vector<Pair>& pairs);

/// The chi-squared quantiles with 2, 4, .. 2 * pairs degrees of freedom at `probability`: entry k - 1 is the gate of k pairs.
/// An even number of degrees of freedom has a closed-form tail, so the whole table costs about a microsecond per ten pairs.
[[nodiscard]] std::vector<double> joint_gates(double probability, Eigen::Index pairs);

}  // namespace ssjs
