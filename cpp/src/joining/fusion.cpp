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

/// Rows of a Jacobian over one map's state: the nonzero blocks, at most one a row.
struct JacobianBlock {
  Eigen::Index row, column, size;  ///< size x size
  Eigen::Matrix3d block;           ///< its top left corner
};

/// What the constraints touch of one map: those components alone decide the relative pose, everything else follows at the end.
class TouchedState {
 public:
  explicit TouchedState(const LiveMap& map) : map_(map) {}

  /// The next `size` components of the map's state from `column` on.
  void touch(Eigen::Index column, Eigen::Index size) {
    columns_.conservativeResize(columns_.size() + size);
    for (Eigen::Index i = 0; i < size; ++i) columns_(columns_.size() - size + i) = static_cast<int>(column + i);
  }
  void gather() {
    prior_ = map_.mean(columns_);
    P_ = map_.covariance(columns_, columns_);
    x = prior_;
  }

  Eigen::VectorXd x;             ///< present estimate of the touched components
  std::vector<JacobianBlock> H;  ///< columns count the touched components

  /// S += H P H'
  void add_covariance(Eigen::MatrixXd& S) const {
    for (const JacobianBlock& r : H) {
      for (const JacobianBlock& c : H) {
        S.block(r.row, c.row, r.size, c.size) += r.block.topLeftCorner(r.size, r.size) * P_.block(r.column, c.column, r.size, c.size) *
                                                 c.block.topLeftCorner(c.size, c.size).transpose();
      }
    }
  }
  /// c += H (prior - x), headings wrapped
  void add_prior_shift(Eigen::VectorXd& c) const {
    for (const JacobianBlock& b : H) {
      Eigen::Vector3d shift = Eigen::Vector3d::Zero();
      shift.head(b.size) = (prior_ - x).segment(b.column, b.size);
      shift.z() = wrap_angle(shift.z());
      c.segment(b.row, b.size) += b.block.topLeftCorner(b.size, b.size) * shift.head(b.size);
    }
  }
  /// x = prior - P H' gain
  void move(const Eigen::VectorXd& gain) {
    Eigen::VectorXd Ht_gain = Eigen::VectorXd::Zero(x.size());
    for (const JacobianBlock& b : H) {
      Ht_gain.segment(b.column, b.size) += b.block.topLeftCorner(b.size, b.size).transpose() * gain.segment(b.row, b.size);
    }
    x = prior_ - P_ * Ht_gain;
  }
  /// P H' over the whole state of the map
  template <class Result>
  void gain_of_all(Result&& PHt) const {
    PHt.setZero();
    for (const JacobianBlock& b : H) {
      PHt.middleCols(b.row, b.size) +=
          map_.covariance.middleCols(columns_(b.column), b.size).lazyProduct(b.block.topLeftCorner(b.size, b.size).transpose());
    }
  }

 private:
  const LiveMap& map_;
  Eigen::VectorXi columns_;  ///< touched components of the map's state
  Eigen::VectorXd prior_;
  Eigen::MatrixXd P_;
};

/// The constraints c(x_a, x_b, tau) = 0, tau = a_T_b: two rows a pair, three rows a shared base (J-8).
class Constraints {
 public:
  Constraints(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, const std::vector<SharedBase>& shared)
      : of_a(a), of_b(b), pairs_(static_cast<Eigen::Index>(pairs.size())), shared_(shared) {
    for (const Pair& pair : pairs) {
      of_a.touch(a.landmark_offset(pair.prediction), 2);
      of_b.touch(b.landmark_offset(pair.observation), 2);
    }
    for (const SharedBase& base : shared) {
      if (base.in_a) of_a.touch(3 * *base.in_a, 3);
      if (base.in_b) of_b.touch(3 * *base.in_b, 3);
    }
    of_a.gather();
    of_b.gather();
    c.resize(rows());
    J.resize(rows(), 3);
  }

  [[nodiscard]] Eigen::Index rows() const { return 2 * pairs_ + 3 * static_cast<Eigen::Index>(shared_.size()); }

  void linearize(const Se2& a_T_b) {
    of_a.H.clear();
    of_b.H.clear();
    Eigen::Matrix3d minus_R = -compose_jacobian_right(a_T_b);
    for (Eigen::Index row = 0; row < 2 * pairs_; row += 2) {
      const Eigen::Vector2d b_p = of_b.x.segment<2>(row);
      c.segment<2>(row) = of_a.x.segment<2>(row) - a_T_b * b_p;
      of_a.H.push_back({row, row, 2, Eigen::Matrix3d::Identity()});
      of_b.H.push_back({row, row, 2, minus_R});
      J.middleRows<2>(row) = -act_jacobian(a_T_b, b_p);
    }
    Eigen::Index row = 2 * pairs_, column_a = 2 * pairs_, column_b = 2 * pairs_;
    for (const SharedBase& base : shared_) {
      Se2 in_a, in_b;
      if (base.in_a) {
        in_a = Se2::from_vector(of_a.x.segment<3>(column_a));
        of_a.H.push_back({row, column_a, 3, Eigen::Matrix3d::Identity()});
        column_a += 3;
      }
      if (base.in_b) {
        in_b = Se2::from_vector(of_b.x.segment<3>(column_b));
        of_b.H.push_back({row, column_b, 3, minus_R});
        column_b += 3;
      }
      c.segment<3>(row) = additive_difference(in_a, a_T_b * in_b);
      J.middleRows<3>(row) = -compose_jacobian_left(a_T_b, in_b);
      row += 3;
    }
  }

  TouchedState of_a, of_b;
  Eigen::VectorXd c;
  Eigen::Matrix<double, Eigen::Dynamic, 3> J;  ///< dc/dtau

 private:
  Eigen::Index pairs_;
  const std::vector<SharedBase>& shared_;
};

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

/// The constrained estimate over (x_a, x_b, tau) in factors (J-9..J-11): Cov(x) = blkdiag(P_a, P_b) - Y Y' + D C D', Cov(x, tau) = D C.
struct JointEstimate {
  Eigen::VectorXd x_a, x_b;
  Se2 a_T_b;
  Eigen::MatrixXd Y;                           ///< P H' L^-T
  Eigen::Matrix<double, Eigen::Dynamic, 3> D;  ///< dx/dtau
  Eigen::Matrix3d C;                           ///< of tau
  double chi_squared = 0.0;
};

JointEstimate solve(const LiveMap& a, const LiveMap& b, Constraints& constraints, const Se2& start) {
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();
  JointEstimate estimate;
  estimate.a_T_b = start;
  Eigen::MatrixXd L;
  Eigen::MatrixXd LiJ;
  Eigen::VectorXd gain;
  const std::string name = "fusion of the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    constraints.linearize(estimate.a_T_b);
    Eigen::MatrixXd S = kConstraintVariance * Eigen::MatrixXd::Identity(constraints.rows(), constraints.rows());
    constraints.of_a.add_covariance(S);
    constraints.of_b.add_covariance(S);
    L = cholesky_lower(S, "constraint covariance", name.c_str());
    Eigen::VectorXd c0 = constraints.c;
    constraints.of_a.add_prior_shift(c0);
    constraints.of_b.add_prior_shift(c0);
    LiJ = L.triangularView<Eigen::Lower>().solve(constraints.J);
    const Eigen::VectorXd Lic = L.triangularView<Eigen::Lower>().solve(c0);
    const Eigen::LLT<Eigen::Matrix3d> information(LiJ.transpose() * LiJ);
    if (information.info() != Eigen::Success) throw NotPositiveDefinite("relative pose", name);
    estimate.C = information.solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d step = -estimate.C * (LiJ.transpose() * Lic);  // (J-9)
    const Eigen::VectorXd whitened = Lic + LiJ * step;
    gain = L.transpose().triangularView<Eigen::Upper>().solve(whitened);
    constraints.of_a.move(gain);  // (J-10)
    constraints.of_b.move(gain);
    estimate.a_T_b = additive_step(estimate.a_T_b, step);
    estimate.chi_squared = whitened.squaredNorm();
  }
  estimate.Y.resize(n_a + n_b, constraints.rows());
  constraints.of_a.gain_of_all(estimate.Y.topRows(n_a));
  constraints.of_b.gain_of_all(estimate.Y.bottomRows(n_b));
  estimate.x_a = a.mean - estimate.Y.topRows(n_a) * gain;
  estimate.x_b = b.mean - estimate.Y.bottomRows(n_b) * gain;
  L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(estimate.Y);
  estimate.D = -estimate.Y * LiJ;  // (J-11)
  return estimate;
}

/// Rows of the two maps that the fused state y = g(x_a, x_b, tau) is made of, and its Jacobian's action (J-12): [a's poses | b's base
/// where a does not know it | b's other poses | a's landmarks | b's unpaired landmarks].
class FusedState {
 public:
  FusedState(const LiveMap& a, const LiveMap& b, const std::vector<bool>& is_paired, const JointEstimate& joint)
      : a_(a), b_(b), joint_(joint), keeps_b_base_(!a.pose_of(b.base)) {
    for (Eigen::Index i = 0; i < b.pose_count(); ++i) {
      const int id = b.poses[static_cast<std::size_t>(i)];
      if (id != a.base && !a.pose_of(id)) b_poses_.push_back(i);
    }
    for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
      if (!is_paired[static_cast<std::size_t>(i)]) b_landmarks_.push_back(i);
    }
    first_b_pose_ = a_poses() + (keeps_b_base_ ? 3 : 0);
    first_a_landmark_ = first_b_pose_ + static_cast<Eigen::Index>(3 * b_poses_.size());
    first_b_landmark_ = first_a_landmark_ + a_landmarks();
    size_ = first_b_landmark_ + static_cast<Eigen::Index>(2 * b_landmarks_.size());
  }

  void name_contents(LiveMap& map) const {
    map.poses = a_.poses;
    map.landmarks = a_.landmarks;
    if (keeps_b_base_) map.poses.push_back(b_.base);
    for (const Eigen::Index i : b_poses_) map.poses.push_back(b_.poses[static_cast<std::size_t>(i)]);
    for (const Eigen::Index i : b_landmarks_) map.landmarks.push_back(b_.landmarks[static_cast<std::size_t>(i)]);
  }

  [[nodiscard]] Eigen::VectorXd mean() const {
    Eigen::VectorXd y(size_);
    y.head(a_poses()) = joint_.x_a.head(a_poses());
    if (keeps_b_base_) y.segment<3>(a_poses()) = joint_.a_T_b.vector();
    for (std::size_t i = 0; i < b_poses_.size(); ++i) {
      y.segment<3>(b_pose_row(i)) = (joint_.a_T_b * b_T_pose(i)).vector();
    }
    y.segment(first_a_landmark_, a_landmarks()) = joint_.x_a.tail(a_landmarks());
    for (std::size_t i = 0; i < b_landmarks_.size(); ++i) y.segment<2>(b_landmark_row(i)) = joint_.a_T_b * b_landmark(i);
    for (Eigen::Index row = 0; row < first_a_landmark_; row += 3) y(row + 2) = wrap_angle(y(row + 2));
    return y;
  }

  /// G blkdiag(P_a, P_b) G' - (G Y)(G Y)' + E C E' with E = G D + dg/dtau: (J-11) and (J-12) in one.
  [[nodiscard]] Eigen::MatrixXd covariance() const {
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(size_, size_);          // lower triangle
    const auto from_a = [&](Eigen::Index row, Eigen::Index column) {  // parts: poses, landmarks
      return a_.covariance.block(row * a_poses(), column * a_poses(), row == 0 ? a_poses() : a_landmarks(),
                                 column == 0 ? a_poses() : a_landmarks());
    };
    P.topLeftCorner(a_poses(), a_poses()) = from_a(0, 0);
    P.block(first_a_landmark_, 0, a_landmarks(), a_poses()) = from_a(1, 0);
    P.block(first_a_landmark_, first_a_landmark_, a_landmarks(), a_landmarks()) = from_a(1, 1);
    const Eigen::MatrixXd P_b = moved_covariance_of_b();
    const Eigen::Index poses = first_a_landmark_ - first_b_pose_;
    const Eigen::Index landmarks = size_ - first_b_landmark_;
    P.block(first_b_pose_, first_b_pose_, poses, poses) = P_b.topLeftCorner(poses, poses);
    P.block(first_b_landmark_, first_b_pose_, landmarks, poses) = P_b.bottomLeftCorner(landmarks, poses);
    P.block(first_b_landmark_, first_b_landmark_, landmarks, landmarks) = P_b.bottomRightCorner(landmarks, landmarks);

    const Eigen::MatrixXd E_root = (moved(joint_.D) + J_tau()) * joint_.C.llt().matrixL().toDenseMatrix();
    P.selfadjointView<Eigen::Lower>().rankUpdate(moved(joint_.Y), -1.0);
    P.selfadjointView<Eigen::Lower>().rankUpdate(E_root, 1.0);
    mirror_lower(P);
    return P;
  }

 private:
  [[nodiscard]] Eigen::Index a_poses() const { return 3 * a_.pose_count(); }
  [[nodiscard]] Eigen::Index a_landmarks() const { return 2 * a_.landmark_count(); }
  [[nodiscard]] Eigen::Index b_pose_row(std::size_t i) const { return first_b_pose_ + static_cast<Eigen::Index>(3 * i); }
  [[nodiscard]] Eigen::Index b_landmark_row(std::size_t i) const { return first_b_landmark_ + static_cast<Eigen::Index>(2 * i); }
  [[nodiscard]] Se2 b_T_pose(std::size_t i) const { return Se2::from_vector(joint_.x_b(LiveMap::pose(b_poses_[i]))); }
  [[nodiscard]] Eigen::Vector2d b_landmark(std::size_t i) const { return joint_.x_b(b_.landmark(b_landmarks_[i])); }

  /// G X for a matrix over (x_a, x_b).
  template <class Matrix>
  [[nodiscard]] Matrix moved(const Matrix& X) const {
    Matrix y(size_, X.cols());
    const Eigen::Index n_a = a_.mean.size();
    y.topRows(a_poses()) = X.topRows(a_poses());
    if (keeps_b_base_) y.middleRows(a_poses(), 3).setZero();
    y.middleRows(first_a_landmark_, a_landmarks()) = X.middleRows(a_poses(), a_landmarks());
    const Eigen::Matrix3d R3 = compose_jacobian_right(joint_.a_T_b);
    for (std::size_t i = 0; i < b_poses_.size(); ++i) {
      y.middleRows(b_pose_row(i), 3) = R3.lazyProduct(X.middleRows(n_a + 3 * b_poses_[i], 3));
    }
    const Eigen::Matrix2d R = joint_.a_T_b.rotation();
    for (std::size_t i = 0; i < b_landmarks_.size(); ++i) {
      y.middleRows(b_landmark_row(i), 2) = R.lazyProduct(X.middleRows(n_a + b_.landmark_offset(b_landmarks_[i]), 2));
    }
    return y;
  }

  /// dg/dtau
  [[nodiscard]] Eigen::Matrix<double, Eigen::Dynamic, 3> J_tau() const {
    Eigen::Matrix<double, Eigen::Dynamic, 3> J = Eigen::MatrixXd::Zero(size_, 3);
    if (keeps_b_base_) J.middleRows<3>(a_poses()).setIdentity();
    for (std::size_t i = 0; i < b_poses_.size(); ++i) J.middleRows<3>(b_pose_row(i)) = compose_jacobian_left(joint_.a_T_b, b_T_pose(i));
    for (std::size_t i = 0; i < b_landmarks_.size(); ++i) {
      J.middleRows<2>(b_landmark_row(i)) = act_jacobian(joint_.a_T_b, b_landmark(i));
    }
    return J;
  }

  /// The kept part of P_b turned into a's frame: poses, then landmarks.
  [[nodiscard]] Eigen::MatrixXd moved_covariance_of_b() const {
    const auto poses = static_cast<Eigen::Index>(3 * b_poses_.size());
    Eigen::VectorXi rows(poses + static_cast<Eigen::Index>(2 * b_landmarks_.size()));
    Eigen::Index row = 0;
    for (const Eigen::Index i : b_poses_) {
      for (Eigen::Index c = 0; c < 3; ++c) rows(row++) = static_cast<int>(3 * i + c);
    }
    for (const Eigen::Index i : b_landmarks_) {
      for (Eigen::Index c = 0; c < 2; ++c) rows(row++) = static_cast<int>(b_.landmark_offset(i) + c);
    }
    Eigen::MatrixXd P = b_.covariance(rows, rows);
    const Eigen::Matrix2d R = joint_.a_T_b.rotation();
    const auto turn_rows = [&](Eigen::Index at) { P.middleRows<2>(at) = (R * P.middleRows<2>(at)).eval(); };
    const auto turn_columns = [&](Eigen::Index at) { P.middleCols<2>(at) = (P.middleCols<2>(at) * R.transpose()).eval(); };
    for (Eigen::Index at = 0; at < poses; at += 3) turn_rows(at), turn_columns(at);
    for (Eigen::Index at = poses; at < P.rows(); at += 2) turn_rows(at), turn_columns(at);
    return P;
  }

  const LiveMap& a_;
  const LiveMap& b_;
  const JointEstimate& joint_;
  bool keeps_b_base_;
  std::vector<Eigen::Index> b_poses_, b_landmarks_;
  Eigen::Index first_b_pose_ = 0, first_a_landmark_ = 0, first_b_landmark_ = 0, size_ = 0;
};

}  // namespace

Fusion fuse(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs) {
  const std::vector<SharedBase> shared = shared_bases(a, b);
  Constraints constraints(a, b, pairs, shared);
  const JointEstimate joint = solve(a, b, constraints, initial_relative_pose(a, b, pairs, shared));
  std::vector<bool> is_paired(b.landmarks.size(), false);
  for (const Pair& pair : pairs) is_paired[static_cast<std::size_t>(pair.observation)] = true;
  const FusedState fused(a, b, is_paired, joint);

  Fusion fusion;
  fusion.chi_squared = joint.chi_squared;
  fusion.dof = static_cast<int>(constraints.rows()) - 3;
  LiveMap& map = fusion.map;
  map.base = a.base;
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), std::back_inserter(map.members));
  fused.name_contents(map);
  for (const Pair& pair : pairs) {
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(pair.prediction)];
    const MapLandmark& other = b.landmarks[static_cast<std::size_t>(pair.observation)];
    kept.take(other);
    if (!kept.source_id) kept.source_id = other.source_id;
  }
  map.mean = fused.mean();
  map.covariance = fused.covariance();
  return fusion;
}

}  // namespace ssjs
