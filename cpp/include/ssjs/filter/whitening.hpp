/// The heart of every Kalman update: gain and normalised innovation without an inverse. docs/math/ekf.md (F-3, F-4).
#pragma once

#include <Eigen/Core>
#include <optional>

namespace ssjs {

/// With the lower Cholesky factor L of S (k x k, lower triangle read): S becomes L, PHt (n x k) becomes Y = P H' L^-T, the innovation
/// becomes L^-1 nu. Then NIS = |L^-1 nu|^2, the step is Y L^-1 nu and P decreases by Y Y' (SymmetricDowndate). Column by column, nothing
/// allocates. Gives the index of the first pivot that is not positive; the arguments are spoilt then.
[[nodiscard]] std::optional<Eigen::Index> whiten(Eigen::Ref<Eigen::MatrixXd> S, Eigen::Ref<Eigen::MatrixXd> PHt,
                                                 Eigen::Ref<Eigen::VectorXd> innovation);

}  // namespace ssjs
