/// Closed-form rigid alignment of paired points in the plane. docs/math/se2.md (S-10).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

/// The a_T_b that minimises sum_i w_i |a_p_i - a_T_b * b_p_i|^2. Points are 2xn, m, one column a pair; weights may be empty (all 1).
/// Empty when fewer than 2 pairs, or when all points of one side coincide (the rotation is then unobservable). Collinear points are fine.
[[nodiscard]] std::optional<Se2> align_points(const Eigen::Ref<const Eigen::Matrix2Xd>& a_points,
                                              const Eigen::Ref<const Eigen::Matrix2Xd>& b_points,
                                              const Eigen::Ref<const Eigen::VectorXd>& weights);

}  // namespace ssjs
