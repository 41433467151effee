/// What two maps that are fused must agree on: their matched landmarks and the base frames both know. docs/math/ssjs.md (J-8).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ssjs/association/hypothesis.hpp"
#include "ssjs/joining/live_map.hpp"

namespace ssjs {

/// A base frame that both maps know: its place among their poses, nothing for a map's own base.
struct SharedBase {
  std::optional<Eigen::Index> in_a;
  std::optional<Eigen::Index> in_b;
};

[[nodiscard]] std::vector<SharedBase> shared_bases(const LiveMap& a, const LiveMap& b);

/// One map's side of the constraints: for every row the component of its state, none where the row takes the map's own base, which is
/// the identity exactly.
class ConstrainedSide {
 public:
  ConstrainedSide(const LiveMap& map, Eigen::Index rows) : map_(map), component_(static_cast<std::size_t>(rows), -1) {}

  void set(Eigen::Index row, Eigen::Index component, Eigen::Index size);
  void gather();  ///< prior, x and P of the rows, once all are set
  /// Covariance of the whole state with the rows.
  [[nodiscard]] Eigen::MatrixXd columns() const;

  Eigen::VectorXd prior, x;  ///< before, and the present estimate
  Eigen::MatrixXd P;

 private:
  const LiveMap& map_;
  std::vector<Eigen::Index> component_;
};

/// The constraints c(x_a, x_b, tau) = x_a - tau x_b = 0, tau = a_T_b: two rows a pair, three rows a shared base (J-8). Row by row, with
/// dc/dx_a = I and dc/dx_b = -R.
class FusionConstraints {
 public:
  FusionConstraints(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, const std::vector<SharedBase>& shared);

  /// c and J = dc/dtau at the present estimate.
  void linearize(const Se2& a_T_b, const Eigen::Matrix2d& R);
  /// c + H (prior - x)
  [[nodiscard]] Eigen::VectorXd at_prior(const Eigen::Matrix2d& R) const;
  /// H P H'
  [[nodiscard]] Eigen::MatrixXd covariance(const Eigen::Matrix2d& R) const;
  /// x = prior - P H' gain
  void move(const Eigen::VectorXd& gain, const Eigen::Matrix2d& R);

  Eigen::VectorXd c;
  Eigen::Matrix<double, Eigen::Dynamic, 3> J;
  ConstrainedSide of_a, of_b;
  std::vector<Eigen::Index> points;    ///< rows where an x, y begins
  std::vector<Eigen::Index> headings;  ///< rows
};

/// M <- M R' for the column pairs (x, y) that begin at `points`; other columns are headings, which no rotation moves.
void turn_columns(Eigen::MatrixXd& M, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R);

/// P <- R P R' of a symmetric P.
void turn(Eigen::MatrixXd& P, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R);

}  // namespace ssjs
