#include "ssjs/joining/constrained_local.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

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
  const auto F = LiveMap::pose(*frame);
  const Se2 a_T_b = a.base_T_pose(*frame);
  const std::vector<Eigen::Index> order = unpaired_first(b, pairs);
  const auto n_pairs = static_cast<Eigen::Index>(pairs.size());
  const Eigen::Index n_new = b.landmark_count() - n_pairs;

  // (K-1) The state [poses of a | exit of b | landmarks of a | landmarks of b], b's moved by a_T_b: J over a_T_b, R over b's own state.
  const Eigen::Index n_a = a.mean.size();
  const Eigen::Index a_poses = 3 * a.pose_count();
  const Eigen::Index exit = a_poses;
  const Eigen::Index from_b = n_a + 3;
  const Eigen::Index n = from_b + 2 * b.landmark_count();
  Eigen::VectorXd x(n);
  x << a.mean.head(a_poses), (a_T_b * b.base_T_pose(0)).vector(), a.mean.tail(n_a - a_poses), Eigen::VectorXd(2 * b.landmark_count());
  Eigen::MatrixXd J(b.mean.size(), 3);
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(b.mean.size(), b.mean.size());  // d(moved) / d(state of b)
  J.topRows<3>() = compose_jacobian_left(a_T_b, b.base_T_pose(0));
  moved.topLeftCorner<3, 3>() = compose_jacobian_right(a_T_b);
  const Eigen::Matrix2d R = a_T_b.rotation();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Eigen::Vector2d b_p = b.mean(b.landmark(order[i]));
    const auto row = static_cast<Eigen::Index>(3 + 2 * i);
    x.segment<2>(from_b + row - 3) = a_T_b * b_p;
    J.middleRows<2>(row) = act_jacobian(a_T_b, b_p);
    moved.block<2, 2>(row, b.landmark_offset(order[i])) = R;
  }
  const Eigen::MatrixXd P_own = moved * b.covariance * moved.transpose() + J * a.covariance(F, F) * J.transpose();
  Eigen::MatrixXd PF(n_a + 3, 3);  // Cov(what is of a, and the exit later, a_T_b)
  PF << a.covariance(Eigen::seqN(0, a_poses), F), Eigen::Matrix3d::Zero(), a.covariance(Eigen::seqN(a_poses, n_a - a_poses), F);
  Eigen::MatrixXd P(n, n);
  P.topLeftCorner(a_poses, a_poses) = a.covariance.topLeftCorner(a_poses, a_poses);
  P.block(from_b - (n_a - a_poses), from_b - (n_a - a_poses), n_a - a_poses, n_a - a_poses) =
      a.covariance.bottomRightCorner(n_a - a_poses, n_a - a_poses);
  P.block(exit + 3, 0, n_a - a_poses, a_poses) = a.covariance.bottomLeftCorner(n_a - a_poses, a_poses);
  P.bottomLeftCorner(n - from_b, from_b).noalias() = J.bottomRows(n - from_b) * PF.transpose();
  P.block(exit, 0, 3, from_b).noalias() = J.topRows<3>() * PF.transpose();
  P.block(exit + 3, exit, n_a - a_poses, 3) = P.block(exit, exit + 3, 3, n_a - a_poses).transpose();
  P.block<3, 3>(exit, exit) = P_own.topLeftCorner<3, 3>();
  P.block(from_b, exit, n - from_b, 3) = P_own.bottomLeftCorner(n - from_b, 3);
  P.bottomRightCorner(n - from_b, n - from_b) = P_own.bottomRightCorner(n - from_b, n - from_b);
  mirror_lower(P);

  // (K-2) The constraint C x = 0: a landmark of a minus its partner from b; and the weighted projection of x onto it.
  Fusion fusion;
  fusion.dof = static_cast<int>(2 * n_pairs);
  if (n_pairs > 0) {
    const auto partners = [&](Eigen::Index i) {
      return std::make_pair(exit + 3 + 2 * pairs[static_cast<std::size_t>(i)].prediction, from_b + 2 * (n_new + i));
    };
    Eigen::MatrixXd PCt(n, 2 * n_pairs);
    Eigen::VectorXd Cx(2 * n_pairs);
    for (Eigen::Index i = 0; i < n_pairs; ++i) {
      const auto [of_a, of_b] = partners(i);
      PCt.middleCols<2>(2 * i) = P.middleCols<2>(of_a) - P.middleCols<2>(of_b);
      Cx.segment<2>(2 * i) = x.segment<2>(of_a) - x.segment<2>(of_b);
    }
    Eigen::MatrixXd S(2 * n_pairs, 2 * n_pairs);
    for (Eigen::Index i = 0; i < n_pairs; ++i) {
      const auto [of_a, of_b] = partners(i);
      S.middleRows<2>(2 * i) = PCt.middleRows<2>(of_a) - PCt.middleRows<2>(of_b);
    }
    S.diagonal().array() += kConstraintVariance;
    const std::string name = "constraints between the maps at bases " + std::to_string(a.base) + " and " + std::to_string(b.base);
    const Eigen::MatrixXd L = cholesky_lower(S, "constraint covariance", name.c_str());
    const Eigen::MatrixXd Y = L.triangularView<Eigen::Lower>().solve(PCt.transpose()).transpose();
    const Eigen::VectorXd whitened = L.triangularView<Eigen::Lower>().solve(Cx);
    x.noalias() -= Y * whitened;
    P.selfadjointView<Eigen::Lower>().rankUpdate(Y, -1.0);
    mirror_lower(P);
    fusion.chi_squared = whitened.squaredNorm();
  }

  // (K-3) The partners from b, now equal to those of a, are dropped.
  LiveMap& map = fusion.map;
  map.base = a.base;
  std::merge(a.members.begin(), a.members.end(), b.members.begin(), b.members.end(), std::back_inserter(map.members));
  map.poses = a.poses;
  map.poses.push_back(b.poses.front());
  map.landmarks = a.landmarks;
  for (const Pair& pair : pairs) {
    MapLandmark& kept = map.landmarks[static_cast<std::size_t>(pair.prediction)];
    const MapLandmark& other = b.landmarks[static_cast<std::size_t>(pair.observation)];
    kept.times_seen += other.times_seen;
    if (!kept.source_id) kept.source_id = other.source_id;
  }
  for (Eigen::Index i = 0; i < n_new; ++i)
    map.landmarks.push_back(b.landmarks[static_cast<std::size_t>(order[static_cast<std::size_t>(i)])]);
  const Eigen::Index kept = n - 2 * n_pairs;
  map.mean = x.head(kept);
  for (Eigen::Index i = 0; i < map.pose_count(); ++i) map.mean(3 * i + 2) = wrap_angle(map.mean(3 * i + 2));
  map.covariance = P.topLeftCorner(kept, kept);
  return fusion;
}

}  // namespace ssjs
