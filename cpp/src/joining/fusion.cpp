#include "ssjs/joining/fusion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_alignment.hpp"

namespace ssjs {
namespace {

constexpr int kIterations = 3;
constexpr double kConstraintVariance = 1e-12;  // exact constraints, kept invertible

/// A base frame that both maps know: its place among their poses, nothing for a map's own base.
struct SharedBase {
  std::optional<Eigen::Index> in_a;
  std::optional<Eigen::Index> in_b;
};

std::vector<SharedBase> shared_bases(const LiveMap& a, const LiveMap& b) {
  std::vector<SharedBase> shared;
  if (const auto in_b = b.pose_of(a.base)) shared.push_back({std::nullopt, in_b});
  if (const auto in_a = a.pose_of(b.base)) shared.push_back({in_a, std::nullopt});
  for (Eigen::Index i = 0; i < a.pose_count(); ++i) {
    if (const auto in_b = b.pose_of(a.poses[static_cast<std::size_t>(i)])) shared.push_back({i, in_b});
  }
  return shared;
}

/// Nonzero block of a Jacobian over one map's state.
struct JacobianBlock {
  Eigen::Index row, column, size;  ///< size x size
  Eigen::Matrix3d block;           ///< its top left corner
};

/// J with few blocks, times anything: P * J' and J * X touch only the blocks' columns and rows.
struct BlockJacobian {
  std::vector<JacobianBlock> blocks;

  void add(Eigen::Index row, Eigen::Index column, const Eigen::Ref<const Eigen::MatrixXd>& block) {
    blocks.push_back({row, column, block.rows(), Eigen::Matrix3d::Zero()});
    blocks.back().block.topLeftCorner(block.rows(), block.rows()) = block;
  }
  /// result = P * J'
  template <class Result>
  void right_transposed(const Eigen::MatrixXd& P, Result&& result) const {
    result.setZero();
    for (const JacobianBlock& b : blocks) {
      result.middleCols(b.row, b.size) += P.middleCols(b.column, b.size).lazyProduct(b.block.topLeftCorner(b.size, b.size).transpose());
    }
  }
  /// result += J * X
  template <class Matrix, class Result>
  void add_left(const Matrix& X, Result&& result) const {
    for (const JacobianBlock& b : blocks) {
      result.middleRows(b.row, b.size) += b.block.topLeftCorner(b.size, b.size).lazyProduct(X.middleRows(b.column, b.size));
    }
  }
};

/// The constraints c(x_a, x_b, tau) = 0, tau = a_T_b: two rows a pair, three rows a shared base (J-8).
class Constraints {
 public:
  Constraints(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, std::vector<SharedBase> shared)
      : a_(a), b_(b), pairs_(pairs), shared_(std::move(shared)) {}

  [[nodiscard]] Eigen::Index rows() const { return static_cast<Eigen::Index>(2 * pairs_.size() + 3 * shared_.size()); }

  void linearize(const Eigen::VectorXd& x_a, const Eigen::VectorXd& x_b, const Se2& a_T_b) {
    c.resize(rows());
    J.resize(rows(), 3);
    H_a.blocks.clear();
    H_b.blocks.clear();
    const Eigen::Matrix2d R = a_T_b.rotation();
    Eigen::Index row = 0;
    for (const Pair& pair : pairs_) {
      const Eigen::Vector2d a_p = x_a(a_.landmark(pair.prediction));
      const Eigen::Vector2d b_p = x_b(b_.landmark(pair.observation));
      const auto rows2 = Eigen::seqN(row, Eigen::fix<2>);
      c(rows2) = a_p - a_T_b * b_p;
      H_a.add(row, a_.landmark_offset(pair.prediction), Eigen::Matrix2d::Identity());
      H_b.add(row, b_.landmark_offset(pair.observation), -R);
      J.middleRows<2>(row) = -act_jacobian(a_T_b, b_p);
      row += 2;
    }
    for (const SharedBase& base : shared_) {
      const Se2 in_a = base.in_a ? Se2::from_vector(x_a(LiveMap::pose(*base.in_a))) : Se2{};
      const Se2 in_b = base.in_b ? Se2::from_vector(x_b(LiveMap::pose(*base.in_b))) : Se2{};
      const auto rows3 = Eigen::seqN(row, Eigen::fix<3>);
      c(rows3) = additive_difference(in_a, a_T_b * in_b);
      if (base.in_a) H_a.add(row, 3 * *base.in_a, Eigen::Matrix3d::Identity());
      if (base.in_b) H_b.add(row, 3 * *base.in_b, -compose_jacobian_right(a_T_b));
      J.middleRows<3>(row) = -compose_jacobian_left(a_T_b, in_b);
      row += 3;
    }
  }

  Eigen::VectorXd c;
  BlockJacobian H_a, H_b;
  Eigen::Matrix<double, Eigen::Dynamic, 3> J;  ///< dc/dtau

 private:
  const LiveMap& a_;
  const LiveMap& b_;
  const std::vector<Pair>& pairs_;
  std::vector<SharedBase> shared_;
};

/// prior - current with the headings of the poses wrapped.
Eigen::VectorXd state_difference(const LiveMap& map, const Eigen::VectorXd& prior, const Eigen::VectorXd& current) {
  Eigen::VectorXd difference = prior - current;
  for (Eigen::Index i = 0; i < map.pose_count(); ++i) difference(3 * i + 2) = wrap_angle(difference(3 * i + 2));
  return difference;
}

Se2 initial_relative_pose(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, const std::vector<SharedBase>& shared) {
  if (!shared.empty()) {
    const Se2 in_a = shared.front().in_a ? a.base_T_pose(*shared.front().in_a) : Se2{};
    const Se2 in_b = shared.front().in_b ? b.base_T_pose(*shared.front().in_b) : Se2{};
    return in_a * in_b.inverse();
  }
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix2Xd a_points(2, n);
  Eigen::Matrix2Xd b_points(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a_points.col(i) = a.mean(a.landmark(pairs[static_cast<std::size_t>(i)].prediction));
    b_points.col(i) = b.mean(b.landmark(pairs[static_cast<std::size_t>(i)].observation));
  }
  const auto a_T_b = align_points(a_points, b_points, Eigen::VectorXd());
  if (!a_T_b) {
    throw NotPositiveDefinite("relative pose", "maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base) +
                                                   " share fewer than two distinct landmarks and no base frame");
  }
  return *a_T_b;
}

/// The constrained estimate over (x_a, x_b, tau), (J-9..J-11).
struct JointEstimate {
  Eigen::VectorXd x_a, x_b;
  Se2 a_T_b;
  Eigen::MatrixXd covariance;  ///< of [x_a; x_b; tau]
  double chi_squared = 0.0;
};

JointEstimate solve(const LiveMap& a, const LiveMap& b, Constraints& constraints, const Se2& start) {
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();
  JointEstimate estimate{a.mean, b.mean, start, {}, 0.0};
  Eigen::MatrixXd PHt(n_a + n_b, constraints.rows());
  Eigen::MatrixXd L;
  Eigen::MatrixXd LiJ;
  Eigen::Matrix3d C_tau;
  const std::string name = "fusion of the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    constraints.linearize(estimate.x_a, estimate.x_b, estimate.a_T_b);
    constraints.H_a.right_transposed(a.covariance, PHt.topRows(n_a));
    constraints.H_b.right_transposed(b.covariance, PHt.bottomRows(n_b));
    Eigen::MatrixXd S = kConstraintVariance * Eigen::MatrixXd::Identity(constraints.rows(), constraints.rows());
    constraints.H_a.add_left(PHt.topRows(n_a), S);
    constraints.H_b.add_left(PHt.bottomRows(n_b), S);
    L = cholesky_lower(S, "constraint covariance", name.c_str());
    Eigen::VectorXd c0 = constraints.c;
    constraints.H_a.add_left(state_difference(a, a.mean, estimate.x_a), c0);
    constraints.H_b.add_left(state_difference(b, b.mean, estimate.x_b), c0);
    LiJ = L.triangularView<Eigen::Lower>().solve(constraints.J);
    const Eigen::VectorXd Lic = L.triangularView<Eigen::Lower>().solve(c0);
    const Eigen::LLT<Eigen::Matrix3d> information(LiJ.transpose() * LiJ);
    if (information.info() != Eigen::Success) throw NotPositiveDefinite("relative pose", name);
    C_tau = information.solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d step = -C_tau * (LiJ.transpose() * Lic);  // (J-9)
    const Eigen::VectorXd whitened = Lic + LiJ * step;
    const Eigen::VectorXd gain = L.transpose().triangularView<Eigen::Upper>().solve(whitened);
    estimate.x_a = a.mean - PHt.topRows(n_a) * gain;  // (J-10)
    estimate.x_b = b.mean - PHt.bottomRows(n_b) * gain;
    estimate.a_T_b = additive_step(estimate.a_T_b, step);
    estimate.chi_squared = whitened.squaredNorm();
  }
  // (J-11): [P - Y Y' + D C D', D C; C D', C] with Y = P H' L^-T and D = dx/dtau = -Y L^-1 J
  const Eigen::Index n = n_a + n_b;
  const Eigen::MatrixXd Y = L.triangularView<Eigen::Lower>().solve(PHt.transpose()).transpose();
  const Eigen::MatrixXd D = -Y * LiJ;
  Eigen::MatrixXd& P = estimate.covariance;
  P.setZero(n + 3, n + 3);
  P.topLeftCorner(n_a, n_a) = a.covariance;
  P.block(n_a, n_a, n_b, n_b) = b.covariance;
  P.topRightCorner(n, 3) = D * C_tau;
  P.bottomLeftCorner(3, n) = P.topRightCorner(n, 3).transpose();
  auto P_maps = P.topLeftCorner(n, n);
  P_maps.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
  P_maps.selfadjointView<Eigen::Lower>().rankUpdate(D * C_tau.llt().matrixL().toDenseMatrix(), 1.0);
  P_maps.triangularView<Eigen::StrictlyUpper>() = P_maps.transpose();
  P.bottomRightCorner<3, 3>() = C_tau;
  return estimate;
}

}  // namespace

Fusion fuse(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs) {
  const std::vector<SharedBase> shared = shared_bases(a, b);
  Constraints constraints(a, b, pairs, shared);
  const JointEstimate joint = solve(a, b, constraints, initial_relative_pose(a, b, pairs, shared));

  // The fused state in a's frame: y = g(x_a, x_b, tau), (J-12). Components: a's poses, b's base and b's other poses where a does
  // not know them, a's landmarks, b's unpaired landmarks.
  Fusion fusion;
  fusion.chi_squared = joint.chi_squared;
  fusion.dof = static_cast<int>(constraints.rows()) - 3;
  LiveMap& map = fusion.map;
  map.base = a.base;
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), std::back_inserter(map.members));
  map.poses = a.poses;
  map.landmarks = a.landmarks;

  const bool keep_b_base = !a.pose_of(b.base);
  std::vector<Eigen::Index> b_poses;
  for (Eigen::Index i = 0; i < b.pose_count(); ++i) {
    const int id = b.poses[static_cast<std::size_t>(i)];
    if (id != a.base && !a.pose_of(id)) b_poses.push_back(i);
  }
  std::vector<bool> paired(b.landmarks.size(), false);
  for (const Pair& pair : pairs) {
    paired[static_cast<std::size_t>(pair.observation)] = true;
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(pair.prediction)];
    const MapLandmark& other = b.landmarks[static_cast<std::size_t>(pair.observation)];
    kept.times_seen += other.times_seen;
    if (!kept.source_id) kept.source_id = other.source_id;
  }
  std::vector<Eigen::Index> b_landmarks;
  for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
    if (!paired[static_cast<std::size_t>(i)]) b_landmarks.push_back(i);
  }
  if (keep_b_base) map.poses.push_back(b.base);
  for (const Eigen::Index i : b_poses) map.poses.push_back(b.poses[static_cast<std::size_t>(i)]);
  for (const Eigen::Index i : b_landmarks) map.landmarks.push_back(b.landmarks[static_cast<std::size_t>(i)]);

  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();
  const Eigen::Index a_pose_size = 3 * a.pose_count();
  const Eigen::Index size = 3 * map.pose_count() + 2 * map.landmark_count();
  const Eigen::MatrixXd& P = joint.covariance;
  map.mean.resize(size);
  // G P, then (G P) G': the rows of G are identities for a and small blocks for b, so both products are row operations.
  const auto apply = [&](const Eigen::MatrixXd& in, Eigen::MatrixXd& out) {
    const auto tau = in.bottomRows<3>();
    Eigen::Index row = a_pose_size;
    out.topRows(a_pose_size) = in.topRows(a_pose_size);
    if (keep_b_base) {
      out.middleRows<3>(row) = tau;
      row += 3;
    }
    const Eigen::Matrix3d J_right = compose_jacobian_right(joint.a_T_b);
    for (const Eigen::Index i : b_poses) {
      const Se2 b_T_pose = Se2::from_vector(joint.x_b(LiveMap::pose(i)));
      out.middleRows<3>(row).noalias() = J_right * in.middleRows<3>(n_a + 3 * i);
      out.middleRows<3>(row).noalias() += compose_jacobian_left(joint.a_T_b, b_T_pose) * tau;
      row += 3;
    }
    out.middleRows(row, n_a - a_pose_size) = in.middleRows(a_pose_size, n_a - a_pose_size);
    row += n_a - a_pose_size;
    const Eigen::Matrix2d R = joint.a_T_b.rotation();
    for (const Eigen::Index i : b_landmarks) {
      const Eigen::Vector2d b_p = joint.x_b(b.landmark(i));
      out.middleRows<2>(row).noalias() = R * in.middleRows<2>(n_a + b.landmark_offset(i));
      out.middleRows<2>(row).noalias() += act_jacobian(joint.a_T_b, b_p) * tau;
      row += 2;
    }
  };
  Eigen::MatrixXd GP(size, n_a + n_b + 3);
  apply(P, GP);
  const Eigen::MatrixXd PGt = GP.transpose();
  map.covariance.resize(size, size);
  apply(PGt, map.covariance);
  map.covariance = (0.5 * (map.covariance + map.covariance.transpose())).eval();

  Eigen::Index row = a_pose_size;
  map.mean.head(a_pose_size) = joint.x_a.head(a_pose_size);
  const auto put_pose = [&](const Se2& pose) {
    map.mean.segment<3>(row) = pose.vector();
    row += 3;
  };
  for (Eigen::Index i = 0; i < a.pose_count(); ++i) map.mean(3 * i + 2) = wrap_angle(map.mean(3 * i + 2));
  if (keep_b_base) put_pose(joint.a_T_b);
  for (const Eigen::Index i : b_poses) put_pose(joint.a_T_b * Se2::from_vector(joint.x_b(LiveMap::pose(i))));
  map.mean.segment(row, n_a - a_pose_size) = joint.x_a.tail(n_a - a_pose_size);
  row += n_a - a_pose_size;
  for (const Eigen::Index i : b_landmarks) {
    map.mean.segment<2>(row) = joint.a_T_b * Eigen::Vector2d(joint.x_b(b.landmark(i)));
    row += 2;
  }
  return fusion;
}

}  // namespace ssjs
