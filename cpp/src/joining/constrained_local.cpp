#include "ssjs/joining/constrained_local.hpp"

#include <algorithm>
#include <iterator>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {
namespace {

constexpr double kConstraintVariance = 1e-12;  // m^2: exact constraints, kept invertible

/// Landmarks of b: those without a partner first, then the partners, which will be dropped.
std::vector<Eigen::Index> unpaired_first(const LiveMap& b, const std::vector<Pair>& pairs) {
  std::vector<bool> paired(b.landmarks.size(), false);
  for (const Pair& pair : pairs) paired[static_cast<std::size_t>(pair.observation)] = true;
  std::vector<Eigen::Index> order;
  for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
    if (!paired[static_cast<std::size_t>(i)]) order.push_back(i);
  }
  for (const Pair& pair : pairs) order.push_back(pair.observation);
  return order;
}

}  // namespace

Fusion project(const LiveMap& a, const LiveMap& b, const std::vector<Pair>& pairs) {
  const auto frame = a.pose_of(b.base);
  if (!frame) throw InvalidArgument("b.base", static_cast<double>(b.base), "is not a pose of the map that it is joined to");
  const Se2 a_T_b = a.base_T_pose(*frame);
  const std::vector<Eigen::Index> order = unpaired_first(b, pairs);
  const auto n_pairs = static_cast<Eigen::Index>(pairs.size());
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index n_b = b.mean.size();

  // (K-1) The state of a beside [exit of b | landmarks of b] moved by the frame F = a_T_b, which is a state of a:
  // Cov(moved, a) = J P_Fa, Cov(moved) = J P_FF J' + G P_b G'.
  Eigen::VectorXd x_b(n_b);
  Eigen::MatrixXd J(n_b, 3);
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n_b, n_b);
  x_b.head<3>() = (a_T_b * b.base_T_pose(0)).vector();
  J.topRows<3>() = compose_jacobian_left(a_T_b, b.base_T_pose(0));
  G.topLeftCorner<3, 3>() = compose_jacobian_right(a_T_b);
  const Eigen::Matrix2d R = a_T_b.rotation();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 + 2 * i);
    const Eigen::Vector2d b_p = b.mean(b.landmark(order[i]));
    x_b.segment<2>(row) = a_T_b * b_p;
    J.middleRows<2>(row) = act_jacobian(a_T_b, b_p);
    G.block<2, 2>(row, b.landmark_offset(order[i])) = R;
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 3> P_frame = a.covariance.middleCols<3>(3 * *frame);
  const Eigen::MatrixXd P_bb = J * P_frame.middleRows<3>(3 * *frame) * J.transpose() + G * b.covariance * G.transpose();

  // (K-2) The constraint C x = 0: a landmark of a minus its partner, which stands at the end of b; the weighted projection onto it.
  const Eigen::Index partners = n_b - 2 * n_pairs;
  Eigen::MatrixXd Y_a(n_a, 2 * n_pairs);  // P C', then P C' L^-T
  Eigen::MatrixXd Y_b = -P_bb.rightCols(2 * n_pairs);
  Eigen::VectorXd x_a = a.mean;
  Eigen::VectorXd Cx(2 * n_pairs);
  for (Eigen::Index i = 0; i < n_pairs; ++i) {
    const Eigen::Index of_a = a.landmark_offset(pairs[static_cast<std::size_t>(i)].prediction);
    Y_a.middleCols<2>(2 * i) = a.covariance.middleCols<2>(of_a) - P_frame * J.middleRows<2>(partners + 2 * i).transpose();
    Y_b.middleCols<2>(2 * i) += J * P_frame.middleRows<2>(of_a).transpose();
    Cx.segment<2>(2 * i) = x_a.segment<2>(of_a) - x_b.segment<2>(partners + 2 * i);
  }
  Eigen::MatrixXd S(2 * n_pairs, 2 * n_pairs);
  if (n_pairs > 0) S = -Y_b.bottomRows(2 * n_pairs);  // a matrix without columns has no address to count rows from
  for (Eigen::Index i = 0; i < n_pairs; ++i) {
    S.middleRows<2>(2 * i) += Y_a.middleRows<2>(a.landmark_offset(pairs[static_cast<std::size_t>(i)].prediction));
  }
  S.diagonal().array() += kConstraintVariance;
  const std::string name = "constraints between the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
  const Eigen::MatrixXd L = cholesky_lower(S, "constraint covariance", name.c_str());
  L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(Y_a);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(Y_b);
  const Eigen::VectorXd whitened = L.triangularView<Eigen::Lower>().solve(Cx);
  x_a.noalias() -= Y_a * whitened;
  x_b.noalias() -= Y_b * whitened;

  // (K-3) The partners, now equal to the landmarks of a, are dropped: [poses of a | exit of b | landmarks of a | new landmarks of b].
  const Eigen::Index poses = 3 * a.pose_count();
  const Eigen::Index n_landmarks = n_a - poses;
  const Eigen::Index n_new = partners - 3;
  const Eigen::Index from_b = n_a + 3;
  Fusion fusion;
  fusion.chi_squared = whitened.squaredNorm();
  fusion.dof = static_cast<int>(2 * n_pairs);
  LiveMap& map = fusion.map;
  map.mean.resize(from_b + n_new);
  map.mean << x_a.head(poses), x_b.head<3>(), x_a.tail(n_landmarks), x_b.segment(3, n_new);
  for (Eigen::Index row = 2; row < poses + 3; row += 3) map.mean(row) = wrap_angle(map.mean(row));
  Eigen::MatrixXd Y(map.mean.size(), 2 * n_pairs);
  if (n_pairs > 0) Y << Y_a.topRows(poses), Y_b.topRows<3>(), Y_a.bottomRows(n_landmarks), Y_b.middleRows(3, n_new);
  Eigen::MatrixXd& P = map.covariance;  // lower triangle
  P.resize(map.mean.size(), map.mean.size());
  P.topLeftCorner(poses, poses) = a.covariance.topLeftCorner(poses, poses);
  P.block(poses + 3, 0, n_landmarks, poses) = a.covariance.bottomLeftCorner(n_landmarks, poses);
  P.block(poses + 3, poses + 3, n_landmarks, n_landmarks) = a.covariance.bottomRightCorner(n_landmarks, n_landmarks);
  P.block(poses, 0, 3, poses) = J.topRows<3>() * P_frame.topRows(poses).transpose();
  P.block(poses + 3, poses, n_landmarks, 3) = P_frame.bottomRows(n_landmarks) * J.topRows<3>().transpose();
  P.block<3, 3>(poses, poses) = P_bb.topLeftCorner<3, 3>();
  P.block(from_b, 0, n_new, poses) = J.middleRows(3, n_new) * P_frame.topRows(poses).transpose();
  P.block(from_b, poses, n_new, 3) = P_bb.block(3, 0, n_new, 3);
  P.block(from_b, poses + 3, n_new, n_landmarks) = J.middleRows(3, n_new) * P_frame.bottomRows(n_landmarks).transpose();
  P.bottomRightCorner(n_new, n_new) = P_bb.block(3, 3, n_new, n_new);
  // Eigen divides by zero in a product of 0 columns and many rows.
  if (n_pairs > 0) P.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
  mirror_lower(P);

  map.base = a.base;
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), std::back_inserter(map.members));
  map.poses = a.poses;
  map.poses.push_back(b.poses.front());
  map.landmarks = a.landmarks;
  for (const Pair& pair : pairs) {
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(pair.prediction)];
    const MapLandmark& other = b.landmarks[static_cast<std::size_t>(pair.observation)];
    kept.take(other);
    if (!kept.source_id) kept.source_id = other.source_id;
  }
  for (Eigen::Index i = 0; i < n_new / 2; ++i)
    map.landmarks.push_back(b.landmarks[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]);
  return fusion;
}

}  // namespace ssjs
