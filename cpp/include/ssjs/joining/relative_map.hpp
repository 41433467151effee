/// The relative stochastic map: the links between consecutive bases as one Gaussian. A new link is independent of all others; a loop
/// correlates those inside it. [estrada2005], docs/math/joining_methods.md (H-1..H-3).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/geometry/gaussian.hpp"

namespace ssjs {

/// tau_ij as something else than the links tells it.
struct ObservedLink {
  int i;
  GaussianSe2 i_T_j;
};

/// Link k is t_k = base k+1 in the frame of base k. Base 0 is the world frame.
class RelativeMap {
 public:
  void append(const GaussianSe2& link);

  [[nodiscard]] int newest_base() const { return static_cast<int>(links_.size()); }
  [[nodiscard]] const Se2& global_T_base(int base) const { return global_T_base_[static_cast<std::size_t>(base)]; }
  [[nodiscard]] const std::vector<Se2>& global_T_bases() const { return global_T_base_; }
  [[nodiscard]] const Se2& link(int k) const { return links_[static_cast<std::size_t>(k)]; }
  /// Of all links, 3 each.
  [[nodiscard]] Eigen::MatrixXd covariance() const { return P_.topLeftCorner(size(), size()); }

  /// tau_ij = t_i (+) ... (+) t_{j-1}, i <= j, with its covariance (H-1).
  [[nodiscard]] GaussianSe2 relative(int i, int j) const;
  /// tau_ij for every i = 0..j.
  [[nodiscard]] std::vector<GaussianSe2> all_relative_to(int j) const;
  /// Of all bases in the world frame, 3 each, base 0 included.
  [[nodiscard]] Eigen::MatrixXd base_covariance() const;

  /// Several tau_ij of one base j were observed, independently of the links and of each other: one stacked iterated Kalman update,
  /// relinearised until it stays where it is or max_iterations are done; 1 is the plain EKF (H-2, H-3). Requires i < j.
  void observe(int j, const std::vector<ObservedLink>& observed, int max_iterations);

 private:
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(3 * links_.size()); }

  std::vector<Se2> links_;
  Eigen::MatrixXd P_;  ///< capacity beyond size()
  std::vector<Se2> global_T_base_{Se2{}};
};

}  // namespace ssjs
