/// What a filter over part of a map does to the rest of it, gathered while it works and applied later, in one go. [guivant2001],
/// docs/math/single_map.md (G-6..G-10).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ssjs/filter/filter_watcher.hpp"

namespace ssjs {

/// The active state A (size a, a0 at the start) is what the watched filter holds; the passive rest B is not looked at:
///   P_BA = P_BA0 phi',   P_BB = P_BB0 - P_BA0 psi P_BA0',   x_B = x_B0 + P_BA0 theta.
/// An update of k components costs O(a a0 k), a prediction O(1). Additive error form, without a frozen pose.
class Compression final : public FilterWatcher {
 public:
  void start(Eigen::Index active_size);

  void on_predict(const Eigen::Matrix3d& F) override;
  void on_update(const std::vector<LinearObservation>& observations, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                 const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::VectorXd>& t) override;
  void on_add(const Eigen::Matrix<double, 2, 3>& J_vehicle) override;
  void on_remove(Eigen::Index landmark, Eigen::Index last) override;

  [[nodiscard]] Eigen::MatrixXd phi() const;                             ///< a x a0
  [[nodiscard]] const Eigen::MatrixXd& psi() const { return psi_; }      ///< a0 x a0, symmetric, semidefinite
  [[nodiscard]] const Eigen::VectorXd& theta() const { return theta_; }  ///< a0
  [[nodiscard]] bool has_updates() const { return has_updates_; }

 private:
  void settle();  ///< applies the pending transition to the vehicle rows

  Eigen::Index rows_ = 0;
  Eigen::MatrixXd phi_;  ///< capacity rows, the first rows_ in use
  Eigen::MatrixXd psi_;
  Eigen::VectorXd theta_;
  Eigen::Matrix3d transition_ = Eigen::Matrix3d::Identity();
  bool has_updates_ = false;

  Eigen::MatrixXd W_;
  Eigen::VectorXd whitened_;
};

}  // namespace ssjs
