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

/// M <- M R' for the column pairs (x, y) that begin at `points`; other columns are headings, which no rotation moves.
void turn_columns(Eigen::MatrixXd& M, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R) {
  for (const Eigen::Index at : points) {
    double* const x = M.col(at).data();
    double* const y = M.col(at + 1).data();
    for (Eigen::Index i = 0; i < M.rows(); ++i) {
      const double old_x = x[i];
      x[i] = R(0, 0) * old_x + R(0, 1) * y[i];
      y[i] = R(1, 0) * old_x + R(1, 1) * y[i];
    }
  }
}

/// R P R' of a symmetric P.
void turn(Eigen::MatrixXd& P, const std::vector<Eigen::Index>& points, const Eigen::Matrix2d& R) {
  turn_columns(P, points, R);
  P.transposeInPlace();
  turn_columns(P, points, R);
}

/// One map's side of the constraints: for every row the component of its state, none where the row takes the map's own base, which is
/// the identity exactly.
class Side {
 public:
  Side(const LiveMap& map, Eigen::Index rows) : map_(map), component_(static_cast<std::size_t>(rows), -1) {}

  void set(Eigen::Index row, Eigen::Index component, Eigen::Index size) {
    for (Eigen::Index i = 0; i < size; ++i) component_[static_cast<std::size_t>(row + i)] = component + i;
  }
  void gather() {
    const auto rows = static_cast<Eigen::Index>(component_.size());
    prior.setZero(rows);
    P.setZero(rows, rows);
    for (Eigen::Index c = 0; c < rows; ++c) {
      const Eigen::Index column = component_[static_cast<std::size_t>(c)];
      if (column < 0) continue;
      prior(c) = map_.mean(column);
      const double* const from = map_.covariance.col(column).data();
      for (Eigen::Index r = 0; r < rows; ++r) {
        const Eigen::Index row = component_[static_cast<std::size_t>(r)];
        if (row >= 0) P(r, c) = from[row];
      }
    }
    x = prior;
  }
  /// Covariance of the whole state with the rows.
  [[nodiscard]] Eigen::MatrixXd columns() const {
    Eigen::MatrixXd all(map_.mean.size(), static_cast<Eigen::Index>(component_.size()));
    for (Eigen::Index c = 0; c < all.cols(); ++c) {
      const Eigen::Index column = component_[static_cast<std::size_t>(c)];
      if (column < 0) {
        all.col(c).setZero();
      } else {
        all.col(c) = map_.covariance.col(column);
      }
    }
    return all;
  }

  Eigen::VectorXd prior, x;  ///< before, and the present estimate
  Eigen::MatrixXd P;

 private:
  const LiveMap& map_;
  std::vector<Eigen::Index> component_;
};

/// The constraints c(x_a, x_b, tau) = x_a - tau x_b = 0, tau = a_T_b: two rows a pair, three rows a shared base (J-8). Row by row, with
/// dc/dx_a = I and dc/dx_b = -R.
class Constraints {
 public:
  Constraints(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs, const std::vector<SharedBase>& shared)
      : c(static_cast<Eigen::Index>(2 * pairs.size() + 3 * shared.size())), J(c.size(), 3), of_a(a, c.size()), of_b(b, c.size()) {
    Eigen::Index row = 0;
    for (const Pair& pair : pairs) {
      of_a.set(row, a.landmark_offset(pair.prediction), 2);
      of_b.set(row, b.landmark_offset(pair.observation), 2);
      points.push_back(row);
      row += 2;
    }
    for (const SharedBase& base : shared) {
      if (base.in_a) of_a.set(row, 3 * *base.in_a, 3);
      if (base.in_b) of_b.set(row, 3 * *base.in_b, 3);
      points.push_back(row);
      headings.push_back(row + 2);
      row += 3;
    }
    of_a.gather();
    of_b.gather();
  }

  /// c and J = dc/dtau at the present estimate.
  void linearize(const Se2& a_T_b, const Eigen::Matrix2d& R) {
    for (const Eigen::Index at : points) {
      const Eigen::Vector2d moved = R * of_b.x.segment<2>(at);
      c.segment<2>(at) = of_a.x.segment<2>(at) - a_T_b.translation() - moved;
      J.middleRows<2>(at) << -1.0, 0.0, moved.y(), 0.0, -1.0, -moved.x();
    }
    for (const Eigen::Index at : headings) {
      c(at) = wrap_angle(of_a.x(at) - a_T_b.heading - of_b.x(at));
      J.row(at) << 0.0, 0.0, -1.0;
    }
  }
  /// c + H (prior - x)
  [[nodiscard]] Eigen::VectorXd at_prior(const Eigen::Matrix2d& R) const {
    const Eigen::VectorXd shift_a = of_a.prior - of_a.x;
    const Eigen::VectorXd shift_b = of_b.prior - of_b.x;
    Eigen::VectorXd c0 = c + shift_a;
    for (const Eigen::Index at : points) c0.segment<2>(at) -= R * shift_b.segment<2>(at);
    for (const Eigen::Index at : headings) c0(at) = c(at) + wrap_angle(shift_a(at)) - wrap_angle(shift_b(at));
    return c0;
  }
  /// H P H'
  [[nodiscard]] Eigen::MatrixXd covariance(const Eigen::Matrix2d& R) const {
    Eigen::MatrixXd S = of_b.P;
    turn(S, points, R);
    S += of_a.P;
    return S;
  }
  /// x = prior - P H' gain
  void move(const Eigen::VectorXd& gain, const Eigen::Matrix2d& R) {
    Eigen::VectorXd Rt_gain = gain;
    for (const Eigen::Index at : points) Rt_gain.segment<2>(at) = R.transpose() * gain.segment<2>(at);
    of_a.x = of_a.prior - of_a.P * gain;
    of_b.x = of_b.prior + of_b.P * Rt_gain;
  }

  Eigen::VectorXd c;
  Eigen::Matrix<double, Eigen::Dynamic, 3> J;
  Side of_a, of_b;
  std::vector<Eigen::Index> points;    ///< rows where an x, y begins
  std::vector<Eigen::Index> headings;  ///< rows
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

/// The last iteration for (x_a, x_b, tau) in factors (J-9..J-11): Cov(x) = blkdiag(P_a, P_b) - Y Y' + D C D', Cov(x, tau) = D C, with
/// Y = P H' L^-T and D = -Y L^-1 J.
struct Solution {
  Se2 a_T_b;
  Eigen::Matrix2d R;     ///< where H was taken
  Eigen::VectorXd gain;  ///< x = prior - P H' gain
  Eigen::MatrixXd L;     ///< of H P H'
  Eigen::Matrix<double, Eigen::Dynamic, 3> LiJ;
  Eigen::Matrix3d C;  ///< of tau
  double chi_squared = 0.0;
};

Solution solve(Constraints& constraints, const Se2& start, const std::string& name) {
  Solution solution;
  solution.a_T_b = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::Matrix2d R = solution.R = solution.a_T_b.rotation();
    constraints.linearize(solution.a_T_b, R);
    Eigen::MatrixXd S = constraints.covariance(R);
    S.diagonal().array() += kConstraintVariance;
    const Eigen::MatrixXd& L = solution.L = cholesky_lower(S, "constraint covariance", name.c_str());
    solution.LiJ = L.triangularView<Eigen::Lower>().solve(constraints.J);
    const Eigen::VectorXd Lic = L.triangularView<Eigen::Lower>().solve(constraints.at_prior(R));
    const Eigen::LLT<Eigen::Matrix3d> information(solution.LiJ.transpose() * solution.LiJ);
    if (information.info() != Eigen::Success) throw NotPositiveDefinite("relative pose", name);
    solution.C = information.solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d step = -solution.C * (solution.LiJ.transpose() * Lic);  // (J-9)
    const Eigen::VectorXd whitened = Lic + solution.LiJ * step;
    solution.gain = L.transpose().triangularView<Eigen::Upper>().solve(whitened);
    constraints.move(solution.gain, R);  // (J-10)
    solution.a_T_b = additive_step(solution.a_T_b, step);
    solution.chi_squared = whitened.squaredNorm();
  }
  return solution;
}

/// The fused state y = g(x_a, x_b, tau): [a's poses | b's base where a does not know it | b's other poses | a's landmarks | b's unpaired
/// landmarks], all that is b's moved by tau (J-12).
class FusedState {
 public:
  FusedState(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs)
      : a_(a), b_(b), a_poses_(3 * a.pose_count()), a_landmarks_(2 * a.landmark_count()), keeps_b_base_(!a.pose_of(b.base)) {
    std::vector<bool> is_paired(b.landmarks.size(), false);
    for (const Pair& pair : pairs) is_paired[static_cast<std::size_t>(pair.observation)] = true;
    Eigen::Index row = a_poses_ + (keeps_b_base_ ? 3 : 0);
    for (Eigen::Index i = 0; i < b.pose_count(); ++i) {
      const int id = b.poses[static_cast<std::size_t>(i)];
      if (id == a.base || a.pose_of(id)) continue;
      poses_.push_back({i, row, 3 * i});
      row += 3;
    }
    first_a_landmark_ = row;
    row += a_landmarks_;
    for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
      if (is_paired[static_cast<std::size_t>(i)]) continue;
      landmarks_.push_back({i, row, b.landmark_offset(i)});
      row += 2;
    }
    size_ = row;
  }

  void name_contents(LiveMap& map) const {
    map.poses = a_.poses;
    map.landmarks = a_.landmarks;
    if (keeps_b_base_) map.poses.push_back(b_.base);
    for (const Kept& pose : poses_) map.poses.push_back(b_.poses[static_cast<std::size_t>(pose.index)]);
    for (const Kept& landmark : landmarks_) map.landmarks.push_back(b_.landmarks[static_cast<std::size_t>(landmark.index)]);
  }

  /// G diag(P_a, P_b) G' - (G Y)(G Y)' + E C E' with E = G D + dg/dtau: (J-11) and (J-12) in one.
  void estimate(const Constraints& constraints, const Solution& solution, LiveMap& map) const {
    const Eigen::MatrixXd PHt_a = constraints.of_a.columns();
    Eigen::MatrixXd PHt_b = constraints.of_b.columns();  // with the other sign
    turn_columns(PHt_b, constraints.points, solution.R);
    const Eigen::VectorXd x_a = a_.mean - PHt_a * solution.gain;
    const Eigen::VectorXd x_b = b_.mean + PHt_b * solution.gain;
    const Se2& a_T_b = solution.a_T_b;
    const Eigen::Matrix2d R = a_T_b.rotation();

    Eigen::MatrixXd Y(size_, PHt_a.cols());  // G P H' so far
    Eigen::MatrixXd E = Eigen::MatrixXd::Zero(size_, 3);
    map.mean.resize(size_);
    Y.topRows(a_poses_) = PHt_a.topRows(a_poses_);
    Y.middleRows(first_a_landmark_, a_landmarks_) = PHt_a.bottomRows(a_landmarks_);
    map.mean.head(a_poses_) = x_a.head(a_poses_);
    map.mean.segment(first_a_landmark_, a_landmarks_) = x_a.tail(a_landmarks_);
    if (keeps_b_base_) {
      Y.middleRows<3>(a_poses_).setZero();
      E.middleRows<3>(a_poses_).setIdentity();
      map.mean.segment<3>(a_poses_) = a_T_b.vector();
    }
    const auto move_point = [&](const Kept& kept) {
      const Eigen::Vector2d moved = R * x_b.segment<2>(kept.component);
      map.mean.segment<2>(kept.row) = a_T_b.translation() + moved;
      E.middleRows<2>(kept.row) << 1.0, 0.0, -moved.y(), 0.0, 1.0, moved.x();
      Y.middleRows<2>(kept.row) = (-R).lazyProduct(PHt_b.middleRows<2>(kept.component));
    };
    for (const Kept& pose : poses_) {
      move_point(pose);
      map.mean(pose.row + 2) = a_T_b.heading + x_b(pose.component + 2);
      E.row(pose.row + 2) << 0.0, 0.0, 1.0;
      Y.row(pose.row + 2) = -PHt_b.row(pose.component + 2);
    }
    for (const Kept& landmark : landmarks_) move_point(landmark);
    for (Eigen::Index row = 0; row < first_a_landmark_; row += 3) map.mean(row + 2) = wrap_angle(map.mean(row + 2));

    for (Eigen::Index j = 0; j < Y.cols(); ++j) {
      for (Eigen::Index i = 0; i < j; ++i) Y.col(j) -= solution.L(j, i) * Y.col(i);
      Y.col(j) *= 1.0 / solution.L(j, j);
    }
    E.noalias() -= Y * solution.LiJ;
    E *= solution.C.llt().matrixL();
    map.covariance = prior_covariance(R);
    map.covariance.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
    map.covariance.selfadjointView<Eigen::Lower>().rankUpdate(E, 1.0);
    mirror_lower(map.covariance);
  }

 private:
  struct Kept {
    Eigen::Index index;      ///< among b's poses or landmarks
    Eigen::Index row;        ///< of the fused state
    Eigen::Index component;  ///< of b's state
  };

  /// G diag(P_a, P_b) G', lower triangle.
  [[nodiscard]] Eigen::MatrixXd prior_covariance(const Eigen::Matrix2d& R) const {
    std::vector<Eigen::Index> components;  // what b keeps, in the order of the fused state
    std::vector<Eigen::Index> points;
    for (const Kept& pose : poses_) {
      points.push_back(static_cast<Eigen::Index>(components.size()));
      for (Eigen::Index c = 0; c < 3; ++c) components.push_back(pose.component + c);
    }
    const auto poses = static_cast<Eigen::Index>(components.size());
    for (const Kept& landmark : landmarks_) {
      points.push_back(static_cast<Eigen::Index>(components.size()));
      for (Eigen::Index c = 0; c < 2; ++c) components.push_back(landmark.component + c);
    }
    const auto kept = static_cast<Eigen::Index>(components.size());
    Eigen::MatrixXd P_b(kept, kept);
    for (Eigen::Index c = 0; c < kept; ++c) {
      const double* const from = b_.covariance.col(components[static_cast<std::size_t>(c)]).data();
      for (Eigen::Index r = 0; r < kept; ++r) P_b(r, c) = from[components[static_cast<std::size_t>(r)]];
    }
    turn(P_b, points, R);

    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(size_, size_);
    P.topLeftCorner(a_poses_, a_poses_) = a_.covariance.topLeftCorner(a_poses_, a_poses_);
    P.block(first_a_landmark_, 0, a_landmarks_, a_poses_) = a_.covariance.bottomLeftCorner(a_landmarks_, a_poses_);
    P.block(first_a_landmark_, first_a_landmark_, a_landmarks_, a_landmarks_) = a_.covariance.bottomRightCorner(a_landmarks_, a_landmarks_);
    const Eigen::Index first_pose = first_a_landmark_ - poses;
    const Eigen::Index landmarks = kept - poses;
    P.block(first_pose, first_pose, poses, poses) = P_b.topLeftCorner(poses, poses);
    P.block(size_ - landmarks, first_pose, landmarks, poses) = P_b.bottomLeftCorner(landmarks, poses);
    P.bottomRightCorner(landmarks, landmarks) = P_b.bottomRightCorner(landmarks, landmarks);
    return P;
  }

  const LiveMap& a_;
  const LiveMap& b_;
  Eigen::Index a_poses_, a_landmarks_;  ///< numbers of the state
  bool keeps_b_base_;
  std::vector<Kept> poses_, landmarks_;  ///< of b
  Eigen::Index first_a_landmark_ = 0, size_ = 0;
};

}  // namespace

Fusion fuse(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs) {
  const std::vector<SharedBase> shared = shared_bases(a, b);
  Constraints constraints(a, b, pairs, shared);
  const std::string name = "fusion of the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
  const Solution solution = solve(constraints, initial_relative_pose(a, b, pairs, shared), name);
  const FusedState fused(a, b, pairs);

  Fusion fusion;
  fusion.chi_squared = solution.chi_squared;
  fusion.dof = static_cast<int>(constraints.c.size()) - 3;
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
  fused.estimate(constraints, solution, map);
  return fusion;
}

}  // namespace ssjs
