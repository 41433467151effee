#include "ssjs/joining/fused_state.hpp"

#include <Eigen/Cholesky>

namespace ssjs {

FusedState::FusedState(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs)
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

void FusedState::name_contents(LiveMap& map) const {
  map.poses = a_.poses;
  map.landmarks = a_.landmarks;
  if (keeps_b_base_) map.poses.push_back(b_.base);
  for (const Kept& pose : poses_) map.poses.push_back(b_.poses[static_cast<std::size_t>(pose.index)]);
  for (const Kept& landmark : landmarks_) map.landmarks.push_back(b_.landmarks[static_cast<std::size_t>(landmark.index)]);
}

void FusedState::estimate(const FusionConstraints& constraints, const FusionSolution& solution, LiveMap& map) const {
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

Eigen::MatrixXd FusedState::prior_covariance(const Eigen::Matrix2d& R) const {
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

}  // namespace ssjs
