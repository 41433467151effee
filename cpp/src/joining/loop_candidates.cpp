#include "ssjs/joining/loop_candidates.hpp"

#include <algorithm>
#include <utility>

namespace ssjs {
namespace {

/// Landmarks of `points` (own frame) that come within reach of the other map's circle, given frame_T_points.
std::vector<Eigen::Index> within_reach(const Eigen::Ref<const Eigen::Matrix2Xd>& points, const Se2& frame_T_points,
                                       const Eigen::Vector2d& frame_centre, double radius) {
  std::vector<Eigen::Index> near;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if ((frame_T_points * Eigen::Vector2d(points.col(i)) - frame_centre).norm() <= radius) near.push_back(i);
  }
  return near;
}

/// Landmark rows of a conditional map, as 2 x n points.
Eigen::Map<const Eigen::Matrix2Xd> landmarks_of(const LiveMap& map, const ConditionalMap& conditional) {
  return {conditional.mean.data() + 3 * (map.pose_count() - map.ports), 2, map.landmark_count()};
}

Eigen::VectorXi landmark_rows(const LiveMap& map, const std::vector<Eigen::Index>& landmarks) {
  Eigen::VectorXi rows(static_cast<Eigen::Index>(2 * landmarks.size()));
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto at = static_cast<int>(3 * (map.pose_count() - map.ports) + 2 * landmarks[i]);
    rows(static_cast<Eigen::Index>(2 * i)) = at;
    rows(static_cast<Eigen::Index>(2 * i) + 1) = at + 1;
  }
  return rows;
}

/// Column of each base of `part` in `all`, which grows by those it lacks.
std::vector<Eigen::Index> columns_in(std::vector<int>& all, const std::vector<int>& part) {
  std::vector<Eigen::Index> columns;
  for (const int base : part) {
    const auto found = std::find(all.begin(), all.end(), base);
    columns.push_back(3 * (found - all.begin()));
    if (found == all.end()) all.push_back(base);
  }
  return columns;
}

/// The encounter of the listed landmarks, without the problem's covariances.
Encounter meet(const LiveMap& a, const LiveMap& b, const GlobalMap& global, Overlap landmarks) {
  const ConditionalMap in_a = condition_on_ports(a, global);
  const ConditionalMap in_b = condition_on_ports(b, global);
  Encounter meeting;
  meeting.a_landmarks = std::move(landmarks.a_landmarks);
  meeting.b_landmarks = std::move(landmarks.b_landmarks);
  const RelativePose tau = relative_pose(global.pose(a.base), global.pose(b.base));
  const auto n_a = static_cast<Eigen::Index>(meeting.a_landmarks.size());
  const auto n_b = static_cast<Eigen::Index>(meeting.b_landmarks.size());
  const std::vector<Eigen::Index> columns_a = columns_in(meeting.bases, in_a.bases);
  const std::vector<Eigen::Index> columns_b = columns_in(meeting.bases, in_b.bases);
  const auto u = static_cast<Eigen::Index>(3 * meeting.bases.size());
  meeting.J_a.setZero(2 * n_a, u);
  meeting.J_b.setZero(2 * n_b, u);
  const Eigen::VectorXi rows_a = landmark_rows(a, meeting.a_landmarks);
  const Eigen::VectorXi rows_b = landmark_rows(b, meeting.b_landmarks);
  meeting.problem.predicted = in_a.mean(rows_a);
  meeting.problem.observed.resize(2 * n_b);
  for (std::size_t i = 0; i < columns_a.size(); ++i) {
    meeting.J_a.middleCols<3>(columns_a[i]) = in_a.J(rows_a, Eigen::seqN(static_cast<Eigen::Index>(3 * i), Eigen::fix<3>));
  }
  const Eigen::Matrix2d R = tau.i_T_j.rotation();
  meeting.noise_a = a.conditional_covariance(rows_a);
  meeting.noise_b = b.conditional_covariance(rows_b);
  for (Eigen::Index i = 0; i < n_b; ++i) {  // q = tau * m_b(s_b(X)), (J-7)
    const Eigen::Vector2d b_p = in_b.mean.segment<2>(rows_b(2 * i));
    meeting.problem.observed.segment<2>(2 * i) = tau.i_T_j * b_p;
    for (std::size_t j = 0; j < columns_b.size(); ++j) {
      meeting.J_b.block<2, 3>(2 * i, columns_b[j]) = R * in_b.J.block<2, 3>(rows_b(2 * i), static_cast<Eigen::Index>(3 * j));
    }
    const Eigen::Matrix<double, 2, 3> J_tau = act_jacobian(tau.i_T_j, b_p);
    meeting.J_b.block<2, 3>(2 * i, columns_a.front()) += J_tau * tau.J_i;
    meeting.J_b.block<2, 3>(2 * i, columns_b.front()) += J_tau * tau.J_j;
    meeting.noise_b.middleRows<2>(2 * i) = R * meeting.noise_b.middleRows<2>(2 * i).eval();
  }
  for (Eigen::Index i = 0; i < n_b; ++i) meeting.noise_b.middleCols<2>(2 * i) = meeting.noise_b.middleCols<2>(2 * i).eval() * R.transpose();
  meeting.P_bases = global.covariance(meeting.bases);
  return meeting;
}

}  // namespace

RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GlobalMap& global) {
  return relative_placement(a, b, global, global.covariance(a.base, b.base));
}

RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GlobalMap& global, const Matrix6d& P_bases) {
  const RelativePose tau = relative_pose(global.pose(a.base), global.pose(b.base));
  const Eigen::Vector2d a_p_centroid = tau.i_T_j * b.centroid;
  Eigen::Matrix<double, 2, 6> J;  // d(a_p_centroid)/d(bases a, b)
  const Eigen::Matrix<double, 2, 3> J_tau = act_jacobian(tau.i_T_j, b.centroid);
  J << J_tau * tau.J_i, J_tau * tau.J_j;
  const Eigen::Matrix2d covariance = J * P_bases * J.transpose();
  return {(a_p_centroid - a.centroid).norm() - a.radius - b.radius, largest_sigma(covariance)};
}

Overlap overlap(const LiveMap& a, const LiveMap& b, const GlobalMap& global, double reach_m) {
  const ConditionalMap in_a = condition_on_ports(a, global);
  const ConditionalMap in_b = condition_on_ports(b, global);
  const Se2 a_T_b = global.pose(a.base).inverse() * global.pose(b.base);
  return {within_reach(landmarks_of(a, in_a), Se2{}, a_T_b * b.centroid, b.radius + reach_m),
          within_reach(landmarks_of(b, in_b), a_T_b, a.centroid, a.radius + reach_m)};
}

Encounter encounter(const LiveMap& a, const LiveMap& b, const GlobalMap& global, Overlap landmarks) {
  Encounter meeting = meet(a, b, global, std::move(landmarks));
  const Eigen::MatrixXd PJt_b = meeting.P_bases * meeting.J_b.transpose();
  meeting.problem.predicted_covariance = meeting.noise_a;
  meeting.problem.predicted_covariance.noalias() += meeting.J_a * (meeting.P_bases * meeting.J_a.transpose()).eval();
  meeting.problem.observed_covariance = meeting.noise_b;
  meeting.problem.observed_covariance.noalias() += meeting.J_b * PJt_b;
  meeting.problem.cross_covariance.noalias() = meeting.J_a * PJt_b;
  return meeting;
}

Encounter encounter(const LiveMap& a, const LiveMap& b, const GlobalMap& global, const std::vector<Pair>& landmark_pairs) {
  Overlap paired;
  for (const Pair& pair : landmark_pairs) {
    paired.a_landmarks.push_back(pair.prediction);
    paired.b_landmarks.push_back(pair.observation);
  }
  return meet(a, b, global, std::move(paired));
}

double displacement_sigma(const Encounter& meeting, const std::vector<Pair>& pairs) {
  double largest = 0.0;
  for (const Pair& pair : pairs) {
    const Eigen::Matrix<double, 2, Eigen::Dynamic> J =
        meeting.J_a.middleRows<2>(2 * pair.prediction) - meeting.J_b.middleRows<2>(2 * pair.observation);
    const Eigen::Matrix<double, 2, Eigen::Dynamic> JP = J * meeting.P_bases;
    largest = std::max(largest, largest_sigma(JP.lazyProduct(J.transpose())));
  }
  return largest;
}

JoinEvidence evidence_of(const Encounter& meeting, const std::vector<Pair>& pairs) {
  const auto rows = static_cast<Eigen::Index>(2 * pairs.size());
  JoinEvidence evidence{meeting.bases, Eigen::VectorXd(rows), Eigen::MatrixXd(rows, meeting.J_a.cols()), Eigen::MatrixXd(rows, rows)};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    const Eigen::Index p = 2 * pairs[i].prediction;
    const Eigen::Index q = 2 * pairs[i].observation;
    evidence.residual.segment<2>(row) = meeting.problem.predicted.segment<2>(p) - meeting.problem.observed.segment<2>(q);  // (J-13)
    evidence.J.middleRows<2>(row) = meeting.J_a.middleRows<2>(p) - meeting.J_b.middleRows<2>(q);
    for (std::size_t j = 0; j < pairs.size(); ++j) {
      evidence.noise.block<2, 2>(row, static_cast<Eigen::Index>(2 * j)) =
          meeting.noise_a.block<2, 2>(p, 2 * pairs[j].prediction) + meeting.noise_b.block<2, 2>(q, 2 * pairs[j].observation);
    }
  }
  return evidence;
}

std::vector<Pair> landmark_pairs(const Encounter& meeting, const std::vector<Pair>& pairs) {
  std::vector<Pair> of_maps;
  for (const Pair& pair : pairs) {
    of_maps.push_back(
        {meeting.b_landmarks[static_cast<std::size_t>(pair.observation)], meeting.a_landmarks[static_cast<std::size_t>(pair.prediction)]});
  }
  return of_maps;
}

}  // namespace ssjs
