/// P -= Y Y' on the lower triangle: the whole cost of a Kalman update with a large map.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ssjs {

/// Owns the packed copy of Y, so that repeated calls of the same size allocate nothing.
class SymmetricDowndate {
 public:
  /// Sizes the workspace once for n rows and k columns.
  void reserve(Eigen::Index n, Eigen::Index k);

  /// Subtracts Y Y' (Y is n x k) from the leading n x n block of P. Reads and writes the lower triangle; entries above the
  /// diagonal inside a 4 x 4 diagonal block are overwritten and have no meaning. P must have at least n rounded up to 4 rows and
  /// columns.
  void operator()(const Eigen::Ref<const Eigen::MatrixXd>& Y, Eigen::MatrixXd& P);

 private:
  std::vector<double> packed_;
};

}  // namespace ssjs
