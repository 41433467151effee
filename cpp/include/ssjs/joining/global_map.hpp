/// The global level: where every live base is in the world, and how surely. It knows ports only.
/// Thesis 3.3.2 to 3.3.4 corrected; docs/math/ssjs.md (J-5, J-13..J-16).
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "ssjs/filter/symmetric_update.hpp"
#include "ssjs/geometry/gaussian.hpp"
#include "ssjs/joining/live_map.hpp"
#include "ssjs/joining/sparse_solver.hpp"

namespace ssjs {

/// How the global level takes new information: one invariant EKF step over a dense covariance, or Gauss-Newton over the port factors.
enum class GlobalSolver { kInvariantEkf, kGaussNewton };

/// What a pairing of two live maps says about the bases, before they are fused: 0 = residual + J dX + n, n ~ N(0, noise) (J-13).
/// J has 3 columns per entry of `bases`.
struct JoinEvidence {
  std::vector<int> bases;
  Eigen::VectorXd residual;
  Eigen::MatrixXd J;
  Eigen::MatrixXd noise;
};

/// Base 0 is the world frame, known exactly. Poses are global_T_base; covariances of additive coordinates.
class GlobalMap {
 public:
  /// dense_bases: above so many live bases the dense covariance gives way to sparse port factors where those are cheaper.
  GlobalMap(GlobalSolver solver, int dense_bases);

  /// A new map attaches: its own base is live, its single port is the next base. (J-5)
  void attach(const LiveMap& map);

  /// `joined` (ports set) replaces the maps at bases a and b; bases that are no longer anyone's base or port are marginalised out.
  /// `changed`: other maps whose ports are fewer now. The sparse level goes on answering as before until settle().
  void replace(int a, int b, const LiveMap& joined, const JoinEvidence& evidence, const std::vector<const LiveMap*>& changed);

  /// To be called when all replacements of one closing are made: the sparse level takes them in together.
  void settle();

  /// Gauss-Newton over all port factors, whatever the solver: the best estimate at the end of a mission.
  void relinearize();

  [[nodiscard]] const Se2& pose(int base) const { return poses_[static_cast<std::size_t>(base)]; }
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<int>& bases) const;
  [[nodiscard]] Matrix6d covariance(int base, int other) const;  ///< of two
  /// Joint covariance of (base, newest), never smaller than the truth of covariance({base, newest}) but for relinearisation: where that
  /// costs a solve, the marginal of `base` is the last one known, and information only grows. For dismissing far maps cheaply.
  [[nodiscard]] Matrix6d covariance_bound(int base, int newest) const;
  [[nodiscard]] const std::vector<int>& bases() const { return live_; }
  [[nodiscard]] bool is_sparse() const { return sparse_; }

 private:
  void set_factor(const LiveMap& map);
  void correct(const JoinEvidence& evidence);
  void forget_unused_bases();
  /// P_(:, blocks), 3 columns for each block, which starts at this row.
  [[nodiscard]] Eigen::MatrixXd dense_columns(const std::vector<Eigen::Index>& blocks) const;
  void go_sparse();
  void go_dense();
  /// Of one closing that fuses, in units that were made equal where both take equally long (benchmarks/README.md).
  [[nodiscard]] double sparse_work() const;
  [[nodiscard]] double dense_work() const;
  void refresh() const;  ///< sparse: factorises where that was not done yet
  void extend_tail(const LiveMap& map);
  [[nodiscard]] Eigen::Matrix3d sparse_cross_covariance(int row_base, int column_base) const;

  bool always_sparse_;
  bool sparse_;
  std::size_t next_comparison_;  ///< dense: of the two ways, above so many live bases
  std::vector<Se2> poses_;       ///< by base index; the entry of a forgotten base is its last estimate
  std::vector<int> live_;        ///< dense: in the order of P_
  Eigen::MatrixXd P_;            ///< dense: of the invariant errors, lower triangle; capacity beyond 3 * live_.size() (J-15)
  SymmetricDowndate downdate_;
  std::map<int, PortFactor> factors_;  ///< by the base of the map
  mutable SparsePoseSolver sparse_solver_;
  mutable bool stale_ = true;
  bool pending_ = false;  ///< sparse: factors were replaced since the last step
  /// Sparse: bases attached since the last factorisation hang on a chain behind the anchor, e = to_anchor * e_anchor + n, n ~ N(0, noise),
  /// so that a closing without a loop costs no factorisation (J-5).
  struct TailBase {
    int base;
    Eigen::Matrix3d to_anchor, noise;
  };
  std::vector<TailBase> tail_;
  int anchor_ = 0;
  mutable std::map<int, Eigen::Matrix3d> known_marginal_;  ///< sparse: last solved
};

}  // namespace ssjs
