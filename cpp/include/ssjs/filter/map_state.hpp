/// The state [vehicle pose | landmarks] and the one place that knows where each block lies.
#pragma once

#include <Eigen/Core>

#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

/// Positions of the blocks of a state of 3 + 2n numbers. Used as P(layout.vehicle(), layout.landmark(i)).
struct StateLayout {
  static constexpr Eigen::Index kVehicle = 3;
  static constexpr Eigen::Index kLandmark = 2;

  [[nodiscard]] static auto vehicle() { return Eigen::seqN(Eigen::Index{0}, Eigen::fix<3>); }
  [[nodiscard]] static auto landmark(Eigen::Index index) { return Eigen::seqN(offset(index), Eigen::fix<2>); }
  [[nodiscard]] static Eigen::Index offset(Eigen::Index landmark) { return kVehicle + kLandmark * landmark; }
  [[nodiscard]] static Eigen::Index size(Eigen::Index landmarks) { return kVehicle + kLandmark * landmarks; }
};

/// Mean and covariance of [x y heading | x y | x y ...] in the submap frame, m and rad.
struct MapState {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< full, symmetric

  [[nodiscard]] Eigen::Index landmarks() const { return (mean.size() - StateLayout::kVehicle) / StateLayout::kLandmark; }
  [[nodiscard]] GaussianSe2 vehicle() const;
  [[nodiscard]] GaussianPoint2 landmark(Eigen::Index index) const;
};

}  // namespace ssjs
