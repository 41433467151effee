#include "ssjs/joining/base_estimate.hpp"

#include <algorithm>

namespace ssjs {

BaseEstimate::BaseEstimate(const GlobalMap& global, int bases)
    : global_(global), global_T_base_(static_cast<std::size_t>(bases)), places_(static_cast<std::size_t>(bases)) {
  for (const int base : global.bases()) global_T_base_[static_cast<std::size_t>(base)] = global.pose(base);
}

void BaseEstimate::add(const LiveMap& map, const WorldMap& in_world) {
  const Eigen::Index inner = map.pose_count() - map.ports;
  if (inner == 0) return;
  for (Eigen::Index i = map.ports; i < map.pose_count(); ++i) {
    const auto base = static_cast<std::size_t>(map.poses[static_cast<std::size_t>(i)]);
    global_T_base_[base] = in_world.global_T_pose[static_cast<std::size_t>(i)];
    places_[base] = {static_cast<int>(families_.size()), 3 * (i - map.ports)};
  }
  families_.push_back(
      {in_world.bases, in_world.J_poses.bottomRows(3 * inner), in_world.pose_noise.bottomRightCorner(3 * inner, 3 * inner)});
}

void BaseEstimate::add(const FrozenBase& frozen) {
  const auto base = static_cast<std::size_t>(frozen.base);
  const Se2& global_T_reference = global_T_base_[static_cast<std::size_t>(frozen.reference)];
  global_T_base_[base] = global_T_reference * frozen.reference_T_base.mean;
  const Eigen::Matrix3d J1 = compose_jacobian_left(global_T_reference, frozen.reference_T_base.mean);
  const Eigen::Matrix3d J2 = compose_jacobian_right(global_T_reference);
  const Eigen::Matrix3d own = J2 * frozen.reference_T_base.covariance * J2.transpose();
  const Place reference = places_[static_cast<std::size_t>(frozen.reference)];
  if (reference.family < 0) {
    places_[base] = {static_cast<int>(families_.size()), 0};
    families_.push_back({{frozen.reference}, J1, own});
    return;
  }
  Family& family = families_[static_cast<std::size_t>(reference.family)];
  const Eigen::Index row = family.J.rows();
  places_[base] = {reference.family, row};
  family.J.conservativeResize(row + 3, Eigen::NoChange);
  family.noise.conservativeResize(row + 3, row + 3);
  family.J.bottomRows<3>() = J1 * family.J.middleRows<3>(reference.row);
  family.noise.bottomLeftCorner(3, row) = J1 * family.noise.block(reference.row, 0, 3, row);
  family.noise.topRightCorner(row, 3) = family.noise.bottomLeftCorner(3, row).transpose();
  family.noise.bottomRightCorner<3, 3>() = J1 * family.noise.block<3, 3>(reference.row, reference.row) * J1.transpose() + own;
}

std::vector<int> BaseEstimate::followed_by(int base) const {
  const Place place = places_[static_cast<std::size_t>(base)];
  return place.family < 0 ? std::vector<int>{base} : families_[static_cast<std::size_t>(place.family)].live;
}

void BaseEstimate::add_derivative(int base, const std::vector<int>& live, Eigen::Ref<Eigen::Matrix<double, 3, Eigen::Dynamic>> J) const {
  const Place place = places_[static_cast<std::size_t>(base)];
  const std::vector<int> followed = followed_by(base);
  for (std::size_t i = 0; i < followed.size(); ++i) {
    const auto column = 3 * (std::find(live.begin(), live.end(), followed[i]) - live.begin());
    if (place.family < 0) {
      J.middleCols<3>(column).setIdentity();
    } else {
      const Family& family = families_[static_cast<std::size_t>(place.family)];
      J.middleCols<3>(column) += family.J.block<3, 3>(place.row, static_cast<Eigen::Index>(3 * i));
    }
  }
}

Eigen::Matrix3d BaseEstimate::noise(int a, int b) const {
  const Place of_a = places_[static_cast<std::size_t>(a)];
  const Place of_b = places_[static_cast<std::size_t>(b)];
  if (of_a.family < 0 || of_a.family != of_b.family) return Eigen::Matrix3d::Zero();
  return families_[static_cast<std::size_t>(of_a.family)].noise.block<3, 3>(of_a.row, of_b.row);
}

Matrix6d BaseEstimate::border_covariance(int k) const {
  std::vector<int> live = followed_by(k);
  for (const int base : followed_by(k + 1)) {
    if (std::find(live.begin(), live.end(), base) == live.end()) live.push_back(base);
  }
  Eigen::Matrix<double, 6, Eigen::Dynamic> J =
      Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, static_cast<Eigen::Index>(3 * live.size()));
  Matrix6d own;
  for (int i = 0; i < 2; ++i) {
    add_derivative(k + i, live, J.middleRows<3>(3 * i));
    for (int j = 0; j < 2; ++j) own.block<3, 3>(3 * i, 3 * j) = noise(k + i, k + j);
  }
  return J * global_.covariance(live) * J.transpose() + own;
}

Eigen::MatrixXd BaseEstimate::joint_covariance() const {
  const std::vector<int>& live = global_.bases();
  const auto bases = static_cast<int>(places_.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3 * Eigen::Index{bases}, static_cast<Eigen::Index>(3 * live.size()));
  for (int base = 0; base < bases; ++base) add_derivative(base, live, J.middleRows<3>(3 * Eigen::Index{base}));
  Eigen::MatrixXd joint = J * global_.covariance(live) * J.transpose();
  for (int a = 0; a < bases; ++a) {
    for (int b = 0; b < bases; ++b) joint.block<3, 3>(3 * Eigen::Index{a}, 3 * Eigen::Index{b}) += noise(a, b);
  }
  return joint;
}

}  // namespace ssjs
