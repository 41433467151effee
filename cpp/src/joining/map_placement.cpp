#include "ssjs/joining/map_placement.hpp"

#include <algorithm>

#include "ssjs/base/error.hpp"
#include "ssjs/geometry/point_grid.hpp"
#include "ssjs/joining/nearby_maps.hpp"

namespace ssjs {
namespace {

Eigen::Matrix2Xd points_of(const LiveMap& map, const Se2& frame_T_map) {
  Eigen::Matrix2Xd points(2, map.landmark_count());
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = frame_T_map * Eigen::Vector2d(map.mean(map.landmark(i)));
  return points;
}

/// The points that have one of the others within reach.
std::vector<Eigen::Index> near_others(const Eigen::Matrix2Xd& points, const Eigen::Matrix2Xd& others, double reach_m) {
  std::vector<Eigen::Index> near;
  const PointGrid grid(others, reach_m);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (!grid.within(points.col(i), reach_m).empty()) near.push_back(i);
  }
  return near;
}

Eigen::VectorXi landmark_rows(const LiveMap& map, const std::vector<Eigen::Index>& landmarks) {
  Eigen::VectorXi rows(static_cast<Eigen::Index>(2 * landmarks.size()));
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto at = static_cast<int>(map.landmark_offset(landmarks[i]));
    rows(static_cast<Eigen::Index>(2 * i)) = at;
    rows(static_cast<Eigen::Index>(2 * i) + 1) = at + 1;
  }
  return rows;
}

}  // namespace

MapPlacement placement_inside(const LiveMap& a, int base) {
  const auto pose = a.pose_of(base);
  if (!pose) throw InvalidArgument("base", static_cast<double>(base), "is not a pose of the map");
  const auto rows = LiveMap::pose(*pose);
  return {{a.base_T_pose(*pose), a.covariance(rows, rows)}, a.covariance(Eigen::all, rows)};
}

RelativePlacement relative_placement(const LiveMap& a, const LiveMap& b, const GaussianSe2& a_T_b) {
  const Eigen::Matrix<double, 2, 3> J = act_jacobian(a_T_b.mean, b.centroid);
  return {(a_T_b.mean * b.centroid - a.centroid).norm() - a.radius - b.radius, largest_sigma(J * a_T_b.covariance * J.transpose())};
}

MapMeeting meet(const LiveMap& a, const LiveMap& b, const MapPlacement& placement) {
  MapMeeting meeting;
  const Se2& a_T_b = placement.a_T_b.mean;
  const Eigen::Matrix3d& C = placement.a_T_b.covariance;
  const Eigen::Matrix2Xd a_points = points_of(a, Se2{});
  const Eigen::Matrix2Xd b_points = points_of(b, a_T_b);
  double sigma_m = 0.0;
  for (Eigen::Index i = 0; i < b.landmark_count(); ++i) {
    const Eigen::Matrix<double, 2, 3> J = act_jacobian(a_T_b, b.mean(b.landmark(i)));
    sigma_m = std::max(sigma_m, largest_sigma(J * C * J.transpose()));
  }
  const double reach_m = kReachSigmas * sigma_m + kReachMargin;
  meeting.a_landmarks = near_others(a_points, b_points, reach_m);
  meeting.b_landmarks = near_others(b_points, a_points, reach_m);

  const Eigen::VectorXi rows_a = landmark_rows(a, meeting.a_landmarks);
  const Eigen::VectorXi rows_b = landmark_rows(b, meeting.b_landmarks);
  PairingProblem& problem = meeting.problem;
  problem.predicted = a.mean(rows_a);
  problem.predicted_covariance = a.covariance(rows_a, rows_a);
  problem.observed.resize(rows_b.size());
  problem.observed_covariance = b.covariance(rows_b, rows_b);
  const Eigen::Matrix2d R = a_T_b.rotation();
  Eigen::MatrixXd J(rows_b.size(), 3);
  for (Eigen::Index i = 0; i < rows_b.size(); i += 2) {
    const auto landmark = meeting.b_landmarks[static_cast<std::size_t>(i / 2)];
    problem.observed.segment<2>(i) = b_points.col(landmark);
    J.middleRows<2>(i) = act_jacobian(a_T_b, b.mean(b.landmark(landmark)));
    problem.observed_covariance.middleRows<2>(i) = R * problem.observed_covariance.middleRows<2>(i).eval();
  }
  for (Eigen::Index i = 0; i < rows_b.size(); i += 2) {
    problem.observed_covariance.middleCols<2>(i) = problem.observed_covariance.middleCols<2>(i).eval() * R.transpose();
  }
  problem.observed_covariance.noalias() += J * (C * J.transpose()).eval();  // (L-1)
  if (placement.cross.size() > 0) {
    const Eigen::MatrixXd cross = placement.cross(rows_a, Eigen::all);
    problem.cross_covariance.noalias() = cross * J.transpose();
  }
  return meeting;
}

std::vector<Pair> landmark_pairs(const MapMeeting& meeting, const std::vector<Pair>& pairs) {
  std::vector<Pair> of_maps;
  of_maps.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    of_maps.push_back(
        {meeting.b_landmarks[static_cast<std::size_t>(pair.observation)], meeting.a_landmarks[static_cast<std::size_t>(pair.prediction)]});
  }
  return of_maps;
}

double displacement_sigma(const LiveMap& a, const LiveMap& b, const MapPlacement& placement, const Pair& pair) {
  const Eigen::Matrix<double, 2, 3> J = act_jacobian(placement.a_T_b.mean, b.mean(b.landmark(pair.observation)));
  Eigen::Matrix2d covariance = J * placement.a_T_b.covariance * J.transpose();
  if (placement.cross.size() > 0) {  // what the landmark of a has in common with the placement is not open
    const auto rows = a.landmark(pair.prediction);
    const Eigen::Matrix2d common = placement.cross(rows, Eigen::all) * J.transpose();
    covariance += a.covariance(rows, rows) - common - common.transpose();
  }
  return largest_sigma(covariance);
}

}  // namespace ssjs
