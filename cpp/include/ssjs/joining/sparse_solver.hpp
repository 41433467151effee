/// Sparse nonlinear least squares over base poses, tied by the port factors of the live maps. docs/math/ssjs.md (J-4, J-16).
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "ssjs/geometry/se2.hpp"

namespace ssjs {

/// What a live map says about its ports: s(X) = (base^-1 * port)_ports ~ N(mean, information^-1), additive coordinates.
struct PortFactor {
  int base = 0;
  std::vector<int> ports;
  Eigen::VectorXd mean;  ///< 3 per port
  Eigen::MatrixXd information;
};

/// Whitenable residual of a factor at the given poses: s(X) - mean with wrapped headings, and its Jacobian over [base, ports...] (J-4).
struct PortResidual {
  Eigen::VectorXd residual;
  Eigen::MatrixXd J;
};
[[nodiscard]] PortResidual port_residual(const PortFactor& factor, const Se2& global_T_base, const std::vector<Se2>& global_T_ports);

class SparsePoseSolver {
 public:
  SparsePoseSolver();
  ~SparsePoseSolver();
  SparsePoseSolver(SparsePoseSolver&&) noexcept;
  SparsePoseSolver& operator=(SparsePoseSolver&&) noexcept;

  /// Gauss-Newton from `poses` (changed in place) over every base that a factor names, base 0 held fixed. Steps are halved while
  /// they do not reduce the cost; it ends where a step promises less than `tolerance` of half chi-squared. Afterwards covariance() answers
  /// at the solution. Returns half the final chi-squared.
  double optimize(const std::map<int, PortFactor>& factors, std::vector<Se2>& poses, double tolerance);

  /// Factorises at `poses` without moving them.
  void factorize(const std::map<int, PortFactor>& factors, const std::vector<Se2>& poses);

  /// Of the last factorisation: multiply-adds it took, and entries of the factor.
  [[nodiscard]] double factor_flops() const;
  [[nodiscard]] double factor_entries() const;

  /// Cov(row_base, column_base), zero for base 0. The columns of a base are solved for once and kept until the factor changes.
  [[nodiscard]] Eigen::Matrix3d cross_covariance(int row_base, int column_base) const;

  /// Joint covariance of the listed bases (additive coordinates, 3 each, base 0 exactly known), by solves with the factor.
  [[nodiscard]] Eigen::MatrixXd covariance(const std::vector<int>& bases) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace ssjs
