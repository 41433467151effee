#include "ssjs/mapping/levelled_journal.hpp"

#include <Eigen/Cholesky>
#include <utility>

namespace ssjs {
namespace {

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;
constexpr double kExitVariance = 1e-12;  // as in TrajectoryJournal: a vehicle that hardly moved, an offset that does not drift

}  // namespace

void LevelledJournal::clear() {
  entries_.clear();
  steps_.clear();
  F_.setIdentity();
}

LevelledJournal::Entry& LevelledJournal::push(Kind kind) {
  Entry& entry = entries_.emplace_back();
  entry.kind = kind;
  entry.F = F_;
  F_.setIdentity();
  return entry;
}

void LevelledJournal::on_predict(const VehicleMatrix& F) { F_ = (F * F_).eval(); }

void LevelledJournal::on_update(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                                const Eigen::Ref<const Eigen::MatrixXd>& L) {
  Entry& entry = push(Kind::kUpdate);
  entry.Y = Y;
  entry.L = L;
  entry.rows = rows;
}

void LevelledJournal::on_add(const Eigen::Matrix<double, 3, VehicleLayout::kSize>& J_vehicle) { push(Kind::kAdd).J_vehicle = J_vehicle; }

void LevelledJournal::step(double time_s, const LevelledFilter& filter) {
  LevelledStep& step = steps_.emplace_back();
  step.time_s = time_s;
  step.base_T_vehicle = filter.vehicle().head<6>();
  step.covariance = filter.vehicle_covariance().topLeftCorner<6, 6>();
  if (conditions_) push(Kind::kStep).Y = filter.pose_rows();
}

std::vector<LevelledStep> LevelledJournal::take_steps(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit) {
  const auto p = static_cast<Eigen::Index>(exit.size());
  if (!conditions_) {
    for (LevelledStep& step : steps_) {
      step.gain.setZero(6, p);
      step.conditional_covariance = step.covariance;
    }
    return take();
  }
  const Eigen::MatrixXd P_exit = filter.covariance()(exit, exit) + kExitVariance * Eigen::MatrixXd::Identity(p, p);
  const Eigen::LLT<Eigen::MatrixXd> factor(P_exit);

  // Lambda with Cov(e_t, e_exit) = P_t Lambda, from the exit backwards (C-3)
  Eigen::MatrixXd lambda = Eigen::MatrixXd::Zero(filter.size(), p);
  for (Eigen::Index i = 0; i < p; ++i) lambda(exit[static_cast<std::size_t>(i)], i) = 1.0;
  Eigen::Index n = filter.size();
  lambda.topRows<kVehicle>() = (F_.transpose() * lambda.topRows<kVehicle>()).eval();
  std::size_t step = steps_.size();
  for (std::size_t i = entries_.size(); i-- > 0;) {
    const Entry& entry = entries_[i];
    switch (entry.kind) {
      case Kind::kStep: {
        LevelledStep& at = steps_[--step];
        const Eigen::MatrixXd with_exit = entry.Y * lambda.topRows(n);
        at.gain = factor.solve(with_exit.transpose()).transpose();  // (C-4)
        at.conditional_covariance = at.covariance - at.gain * with_exit.transpose();
        at.conditional_covariance = (0.5 * (at.conditional_covariance + at.conditional_covariance.transpose())).eval();
        break;
      }
      case Kind::kUpdate: {  // Lambda <- (I - K H)' Lambda, K = Y L^-1
        Eigen::MatrixXd KtLambda = entry.Y.transpose() * lambda.topRows(n);
        entry.L.triangularView<Eigen::Lower>().transpose().solveInPlace(KtLambda);
        Eigen::Index row = 0;
        for (const StateRows& block : entry.rows) {
          lambda.topRows<kVehicle>().noalias() -= block.vehicle.H.transpose() * KtLambda.middleRows(row, block.rows());
          if (block.landmark != StateRows::kNoLandmark) {
            lambda.middleRows<3>(LevelledFilter::offset(block.landmark)).noalias() -=
                block.H_landmark.transpose() * KtLambda.middleRows(row, block.rows());
          }
          row += block.rows();
        }
        break;
      }
      case Kind::kAdd: {
        n -= 3;
        lambda.topRows<kVehicle>().noalias() += entry.J_vehicle.transpose() * lambda.middleRows<3>(n);
        break;
      }
    }
    lambda.topRows<kVehicle>() = (entry.F.transpose() * lambda.topRows<kVehicle>()).eval();
  }
  return take();
}

std::vector<LevelledStep> LevelledJournal::take() {
  std::vector<LevelledStep> taken = std::move(steps_);
  clear();
  return taken;
}

}  // namespace ssjs
