/// Sees the linear operations that an EKF performs on its error, as they happen.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ssjs {

struct LinearObservation;

/// The filter's error e = estimate - truth evolves as e <- F e (vehicle), e <- (I + t h') (I - K H) e (update, h' picks the heading,
/// t is zero for an additive correction), and by landmarks that come and go.
class FilterWatcher {
 public:
  FilterWatcher() = default;
  FilterWatcher(const FilterWatcher&) = delete;
  FilterWatcher& operator=(const FilterWatcher&) = delete;
  virtual ~FilterWatcher() = default;

  virtual void on_predict(const Eigen::Matrix3d& F) = 0;
  /// K = Y L^-1 with Y = P H' L^-T (n x k) and L the lower Cholesky factor of the innovation covariance (k x k).
  virtual void on_update(const std::vector<LinearObservation>& observations, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                         const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::VectorXd>& t) = 0;
  virtual void on_add(const Eigen::Matrix<double, 2, 3>& J_vehicle) = 0;
  virtual void on_remove(Eigen::Index landmark, Eigen::Index last) = 0;
};

}  // namespace ssjs
