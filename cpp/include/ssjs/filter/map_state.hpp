/// The state [vehicle pose | landmarks] and the one place that knows where each block lies.
#pragma once

#include <Eigen/Core>

#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

/// Positions of the blocks of a state of 3 + 2n numbers, or of 6 + 2n where a frozen pose stands behind the vehicle: a past pose that
/// no motion moves. Used as P(layout.vehicle(), layout.landmark(i)).
struct StateLayout {
  static constexpr Eigen::Index kVehicle = 3;
  static constexpr Eigen::Index kLandmark = 2;

  bool has_frozen_pose = false;

  [[nodiscard]] static auto vehicle() { return Eigen::seqN(Eigen::Index{0}, Eigen::fix<3>); }
  [[nodiscard]] static auto frozen_pose() { return Eigen::seqN(kVehicle, Eigen::fix<3>); }
  [[nodiscard]] auto landmark(Eigen::Index index) const { return Eigen::seqN(offset(index), Eigen::fix<2>); }
  [[nodiscard]] Eigen::Index offset(Eigen::Index landmark) const { return poses() + kLandmark * landmark; }
  [[nodiscard]] Eigen::Index size(Eigen::Index landmarks) const { return poses() + kLandmark * landmarks; }
  [[nodiscard]] Eigen::Index poses() const { return has_frozen_pose ? 2 * kVehicle : kVehicle; }  ///< numbers before the landmarks
};

/// Mean and covariance of [x y heading | x y | x y ...] in the submap frame, m and rad.
struct MapState {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< full, symmetric
  StateLayout layout{};

  [[nodiscard]] Eigen::Index landmarks() const { return (mean.size() - layout.poses()) / StateLayout::kLandmark; }
  [[nodiscard]] GaussianSe2 vehicle() const;
  [[nodiscard]] GaussianPoint2 landmark(Eigen::Index index) const;
};

}  // namespace ssjs
