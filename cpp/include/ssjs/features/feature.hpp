/// One observation of a point landmark.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace ssjs {

/// Range and bearing of a point in the sensor frame: bearing 0 straight ahead, anticlockwise positive.
struct Feature {
  Eigen::Vector2d range_bearing = Eigen::Vector2d::Zero();  ///< m, rad
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();     ///< of (range m, bearing rad)
  std::optional<std::int64_t> landmark_id;                  ///< where the source knows it (barcode, simulation)

  [[nodiscard]] double range() const { return range_bearing.x(); }
  [[nodiscard]] double bearing() const { return range_bearing.y(); }
};

using Features = std::vector<Feature>;

}  // namespace ssjs
