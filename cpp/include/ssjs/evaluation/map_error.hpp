/// Errors of a landmark map against surveyed landmarks. docs/math/evaluation.md (E-6, E-7).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

struct MapErrorConfig {
  double max_distance_m = 10.0;  ///< pairs farther apart are a missed and a false landmark
  bool align = false;            ///< rigid alignment of the paired landmarks first (the shape of the map alone)
};

struct MapError {
  int matched = 0, missed = 0, false_landmarks = 0;
  double mean_m = 0.0, std_m = 0.0, max_m = 0.0, rmse_m = 0.0;
  std::vector<std::optional<Eigen::Index>> truth_of;  ///< per estimated landmark
};

/// One to one: by identity where `estimated_ids` holds one that the truth knows (a repeated identity keeps its nearest copy, the
/// others count as false), otherwise the assignment of least total distance within max_distance_m, where an estimate left alone counts
/// max_distance_m. Points are 2xn, m. Empty when nothing matches, or when fewer than two pairs are to be aligned.
[[nodiscard]] std::optional<MapError> map_error(const Eigen::Ref<const Eigen::Matrix2Xd>& estimated,
                                                const std::vector<std::optional<std::int64_t>>& estimated_ids,
                                                const Eigen::Ref<const Eigen::Matrix2Xd>& truth, const std::vector<std::int64_t>& truth_ids,
                                                const MapErrorConfig& config);

}  // namespace ssjs
