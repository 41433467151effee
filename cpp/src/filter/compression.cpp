#include "ssjs/filter/compression.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "ssjs/base/error.hpp"
#include "ssjs/filter/ekf.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kVehicle = StateLayout::kVehicle;

}  // namespace

void Compression::start(Eigen::Index active_size) {
  rows_ = active_size;
  phi_.setIdentity(active_size, active_size);
  psi_.setZero(active_size, active_size);
  theta_.setZero(active_size);
  transition_.setIdentity();
  has_updates_ = false;
}

void Compression::on_predict(const Eigen::Matrix3d& F) { transition_ = F * transition_; }

void Compression::settle() {
  phi_.topRows<kVehicle>() = (transition_ * phi_.topRows<kVehicle>()).eval();  // (G-7)
  transition_.setIdentity();
}

void Compression::on_update(const std::vector<LinearObservation>& observations, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                            const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::VectorXd>& t) {
  if (!t.isZero(0.0)) throw InvalidArgument("Compression filter", "invariant error form", "only the additive form can be compressed");
  settle();
  const auto k = L.rows();
  W_.resize(k, phi_.cols());
  whitened_.resize(k);
  for (Eigen::Index i = 0; i < k; i += 2) {
    const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
    W_.middleRows<2>(i).noalias() = z.H_vehicle * phi_.topRows<kVehicle>();
    W_.middleRows<2>(i).noalias() += z.H_landmark * phi_.middleRows<2>(StateLayout().offset(z.landmark));
    whitened_.segment<2>(i) = z.residual;
  }
  L.triangularView<Eigen::Lower>().solveInPlace(W_);         // W = L^-1 H phi
  L.triangularView<Eigen::Lower>().solveInPlace(whitened_);  // L^-1 nu
  psi_.noalias() += W_.transpose() * W_;                     // (G-8)
  theta_.noalias() += W_.transpose() * whitened_;
  phi_.topRows(rows_).noalias() -= Y * W_;  // (G-8): K H phi = Y L^-1 H phi
  has_updates_ = true;
}

void Compression::on_add(const Eigen::Matrix<double, 2, 3>& J_vehicle) {
  settle();
  if (rows_ + 2 > phi_.rows()) phi_.conservativeResize(std::max(rows_ + 2, 2 * phi_.rows()), phi_.cols());
  phi_.middleRows<2>(rows_).noalias() = J_vehicle * phi_.topRows<kVehicle>();  // (G-9)
  rows_ += 2;
}

void Compression::on_remove(Eigen::Index landmark, Eigen::Index last) {
  const StateLayout layout;
  if (landmark != last) phi_.middleRows<2>(layout.offset(landmark)) = phi_.middleRows<2>(layout.offset(last)).eval();  // (G-9)
  rows_ -= 2;
}

Eigen::MatrixXd Compression::phi() const {
  Eigen::MatrixXd phi = phi_.topRows(rows_);
  phi.topRows<kVehicle>() = (transition_ * phi.topRows<kVehicle>()).eval();
  return phi;
}

}  // namespace ssjs
