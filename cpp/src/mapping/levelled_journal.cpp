#include "ssjs/mapping/levelled_journal.hpp"

#include <Eigen/Cholesky>
#include <utility>

#include "ssjs/base/angle.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kVehicle = VehicleLayout::kSize;
constexpr double kExitVariance = 1e-12;  // as in TrajectoryJournal: a vehicle that hardly moved, an offset that does not drift

/// What a pose of the past has to do with all that came after it, going back from the exit of the map.
class Backwards {
 public:
  Backwards(Eigen::Index size, const std::vector<Eigen::Index>& exit)
      : n_(size),
        lambda_(Eigen::MatrixXd::Zero(size, static_cast<Eigen::Index>(exit.size()))),
        mu_(Eigen::VectorXd::Zero(size)),
        M_(Eigen::MatrixXd::Zero(size, size)) {
    for (std::size_t i = 0; i < exit.size(); ++i) lambda_(exit[i], static_cast<Eigen::Index>(i)) = 1.0;
  }

  [[nodiscard]] auto lambda() const { return lambda_.topRows(n_); }            ///< Cov(e_t, e_exit) = P_t Lambda
  [[nodiscard]] auto mu() const { return mu_.head(n_); }                       ///< smoothed = filtered + P_t mu
  [[nodiscard]] auto information() const { return M_.topLeftCorner(n_, n_); }  ///< P smoothed = P_t - P_t M P_t

  void motion(const VehicleMatrix& F) {
    lambda_.topRows<kVehicle>() = (F.transpose() * lambda_.topRows<kVehicle>()).eval();
    mu_.head<kVehicle>() = (F.transpose() * mu_.head<kVehicle>()).eval();
    M_.topLeftCorner(kVehicle, n_) = (F.transpose() * M_.topLeftCorner(kVehicle, n_)).eval();
    M_.topLeftCorner(n_, kVehicle) = (M_.topLeftCorner(n_, kVehicle) * F).eval();
  }

  void update(const std::vector<StateRows>& rows, const Eigen::MatrixXd& Y, const Eigen::MatrixXd& L) {
    const auto lower = L.triangularView<Eigen::Lower>();
    const auto transposed_K_times = [&](const auto& right) {  // K = Y L^-1
      Eigen::MatrixXd product = Y.transpose() * right;
      lower.transpose().solveInPlace(product);
      return product;
    };
    Eigen::VectorXd innovation(Y.cols());
    Eigen::Index row = 0;
    for (const StateRows& block : rows) {
      innovation.segment(row, block.rows()) = block.vehicle.residual;
      row += block.rows();
    }
    lower.solveInPlace(innovation);
    lower.transpose().solveInPlace(innovation);  // S^-1 nu
    const Eigen::MatrixXd Kt_lambda = transposed_K_times(lambda());
    const Eigen::VectorXd Kt_mu = transposed_K_times(mu());
    const Eigen::MatrixXd Kt_M = transposed_K_times(information());
    Eigen::MatrixXd within = Eigen::MatrixXd::Identity(Y.cols(), Y.cols());  // S^-1 + K' M K
    lower.solveInPlace(within);
    lower.transpose().solveInPlace(within);
    within += transposed_K_times(Kt_M.transpose());
    subtract_Ht(rows, Kt_lambda, lambda_);
    subtract_Ht(rows, Kt_mu - innovation, mu_);
    // (I - KH)' M (I - KH) + H' S^-1 H = M - H' K'M - (H' K'M)' + H' (S^-1 + K' M K) H
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(n_, n_);
    subtract_Ht(rows, Kt_M, left);
    Eigen::MatrixXd HtW = Eigen::MatrixXd::Zero(n_, Y.cols());
    subtract_Ht(rows, -within, HtW);
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(n_, n_);
    subtract_Ht(rows, -HtW.transpose(), both);
    M_.topLeftCorner(n_, n_) += left + left.transpose() + both;
    // symmetric again: of an error that is not, this recursion makes (I - KH)' E (I + KH), which grows
    M_.topLeftCorner(n_, n_) = (0.5 * (information() + information().transpose())).eval();
  }

  /// Before this landmark was added.
  void addition(const Eigen::Matrix<double, 3, VehicleLayout::kSize>& J) {
    n_ -= 3;
    lambda_.topRows<kVehicle>().noalias() += J.transpose() * lambda_.middleRows<3>(n_);
    mu_.head<kVehicle>().noalias() += J.transpose() * mu_.segment<3>(n_);
    M_.topLeftCorner(kVehicle, n_ + 3).noalias() += J.transpose() * M_.block(n_, 0, 3, n_ + 3);
    M_.topLeftCorner(n_, kVehicle).noalias() += M_.block(0, n_, n_, 3) * J;
  }

 private:
  /// target -= H' right.
  static void subtract_Ht(const std::vector<StateRows>& rows, const Eigen::MatrixXd& right, Eigen::Ref<Eigen::MatrixXd> target) {
    Eigen::Index row = 0;
    for (const StateRows& block : rows) {
      target.topRows<kVehicle>().noalias() -= block.vehicle.H.transpose() * right.middleRows(row, block.rows());
      if (block.landmark != StateRows::kNoLandmark) {
        target.middleRows<3>(LevelledFilter::offset(block.landmark)).noalias() -=
            block.H_landmark.transpose() * right.middleRows(row, block.rows());
      }
      row += block.rows();
    }
  }

  Eigen::Index n_;
  Eigen::MatrixXd lambda_;
  Eigen::VectorXd mu_;
  Eigen::MatrixXd M_;
};

}  // namespace

void LevelledJournal::clear() {
  entries_.clear();
  steps_.clear();
  bytes_ = 0;
  F_.setIdentity();
}

LevelledJournal::Entry& LevelledJournal::push(Kind kind) {
  Entry& entry = entries_.emplace_back();
  entry.kind = kind;
  entry.F = F_;
  F_.setIdentity();
  return entry;
}

std::size_t LevelledJournal::bytes_of(const Entry& entry) {
  return sizeof(Entry) + sizeof(double) * static_cast<std::size_t>(entry.Y.size() + entry.L.size()) + sizeof(StateRows) * entry.rows.size();
}

/// After the newest entry was filled in.
void LevelledJournal::limit() {
  bytes_ += bytes_of(entries_.back());
  while (bytes_ > most_bytes_ && entries_.size() > 1) {
    bytes_ -= bytes_of(entries_.front());
    entries_.pop_front();
  }
}

void LevelledJournal::on_predict(const VehicleMatrix& F) { F_ = (F * F_).eval(); }

void LevelledJournal::on_update(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                                const Eigen::Ref<const Eigen::MatrixXd>& L) {
  Entry& entry = push(Kind::kUpdate);
  entry.Y = Y;
  entry.L = L;
  entry.rows = rows;
  limit();
}

void LevelledJournal::on_add(const Eigen::Matrix<double, 3, VehicleLayout::kSize>& J_vehicle) {
  push(Kind::kAdd).J_vehicle = J_vehicle;
  limit();
}

void LevelledJournal::step(double time_s, const LevelledFilter& filter) {
  LevelledStep& step = steps_.emplace_back();
  step.time_s = time_s;
  step.base_T_vehicle = filter.vehicle().head<6>();
  step.covariance = filter.vehicle_covariance().topLeftCorner<6, 6>();
  if (!conditions_) return;
  push(Kind::kStep).Y = filter.pose_rows();
  limit();
}

std::vector<LevelledStep> LevelledJournal::take_steps(const LevelledFilter& filter, const std::vector<Eigen::Index>& exit) {
  const auto p = static_cast<Eigen::Index>(exit.size());
  for (LevelledStep& step : steps_) {
    step.gain.setZero(6, p);
    step.conditional_covariance = step.covariance;
  }
  if (!conditions_) return take();
  const Eigen::MatrixXd P_exit = filter.covariance()(exit, exit) + kExitVariance * Eigen::MatrixXd::Identity(p, p);
  const Eigen::LLT<Eigen::MatrixXd> factor(P_exit);

  Backwards back(filter.size(), exit);
  back.motion(F_);
  std::size_t step = steps_.size();
  for (std::size_t i = entries_.size(); i-- > 0;) {
    const Entry& entry = entries_[i];
    switch (entry.kind) {
      case Kind::kStep: {
        LevelledStep& at = steps_[--step];
        const Eigen::MatrixXd with_exit = entry.Y * back.lambda();
        at.gain = factor.solve(with_exit.transpose()).transpose();  // (C-4)
        at.base_T_vehicle += entry.Y * back.mu();
        for (Eigen::Index angle = 3; angle < 6; ++angle) at.base_T_vehicle(angle) = wrap_angle(at.base_T_vehicle(angle));
        at.covariance -= entry.Y * back.information() * entry.Y.transpose();
        at.covariance = (0.5 * (at.covariance + at.covariance.transpose())).eval();
        at.conditional_covariance = at.covariance - at.gain * with_exit.transpose();
        at.conditional_covariance = (0.5 * (at.conditional_covariance + at.conditional_covariance.transpose())).eval();
        break;
      }
      case Kind::kUpdate:
        back.update(entry.rows, entry.Y, entry.L);
        break;
      case Kind::kAdd:
        back.addition(entry.J_vehicle);
        break;
    }
    back.motion(entry.F);
  }
  return take();
}

std::vector<LevelledStep> LevelledJournal::take() {
  std::vector<LevelledStep> taken = std::move(steps_);
  clear();
  return taken;
}

void LevelledJournal::archive(Archive& a) {
  a("entries", entries_);
  a("steps", steps_);
  a("F", F_);
  if (!a.reading()) return;
  bytes_ = 0;
  for (const Entry& entry : entries_) bytes_ += bytes_of(entry);
}

}  // namespace ssjs
