#include "ssjs/filter/levelled_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/filter/whitening.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kInitialRows = 24;  // of one stacked update; more is a one-time growth

std::string name_of(const StateRows& rows) {
  if (rows.landmark != StateRows::kNoLandmark) return "landmark " + std::to_string(rows.landmark) + " of the map";
  return "a navigation sensor (" + std::to_string(rows.rows()) + " rows)";
}

}  // namespace

LevelledFilter::LevelledFilter(Eigen::Index landmark_capacity) {
  S_.resize(kInitialRows, kInitialRows);
  innovation_.resize(kInitialRows);
  reserve(std::max<Eigen::Index>(landmark_capacity, 1));
}

void LevelledFilter::reserve(Eigen::Index landmarks) {
  if (landmarks <= capacity_) return;
  capacity_ = std::max(landmarks, 2 * capacity_);
  const Eigen::Index n = (offset(capacity_) + 3) / 4 * 4;  // whole tiles of SymmetricDowndate
  const Eigen::Index old = P_.rows();
  mean_.conservativeResize(n);
  mean_.tail(n - old).setZero();
  P_.conservativeResize(n, n);
  P_.bottomRows(n - old).setZero();
  P_.rightCols(n - old).setZero();
  PHt_.resize(n, S_.cols());
  downdate_.reserve(n, S_.cols());
}

void LevelledFilter::reset(const VehicleVector& vehicle, const VehicleMatrix& covariance) {
  landmarks_ = 0;
  mean_.head<kVehicle>() = vehicle;
  P_.topLeftCorner<kVehicle, kVehicle>() = covariance;
}

VehicleMatrix LevelledFilter::vehicle_covariance() const { return P_.topLeftCorner<kVehicle, kVehicle>().selfadjointView<Eigen::Lower>(); }

Eigen::MatrixXd LevelledFilter::covariance() const { return P_.topLeftCorner(size(), size()).selfadjointView<Eigen::Lower>(); }

Eigen::Matrix<double, 6, Eigen::Dynamic> LevelledFilter::pose_rows() const {
  Eigen::Matrix<double, 6, Eigen::Dynamic> rows(6, size());
  read_pose_rows(rows);
  return rows;
}

void LevelledFilter::read_pose_rows(Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> rows) const {
  rows.leftCols<kVehicle>() = vehicle_covariance().topRows<6>();
  rows.rightCols(size() - kVehicle) = P_.block(kVehicle, 0, size() - kVehicle, 6).transpose();
}

void LevelledFilter::predict(const VehiclePrediction& motion) {
  const Eigen::Index m = size() - kVehicle;
  mean_.head<kVehicle>() = motion.state;
  P_.topLeftCorner<kVehicle, kVehicle>() = motion.F * vehicle_covariance() * motion.F.transpose() + motion.Q;  // (F-1)
  for (Eigen::Index r = 0; r < m; ++r) {
    const VehicleVector row = motion.F * P_.block<1, kVehicle>(kVehicle + r, 0).transpose();
    P_.block<1, kVehicle>(kVehicle + r, 0) = row.transpose();
  }
  if (watcher_ != nullptr) watcher_->on_predict(motion.F);
}

void LevelledFilter::add_landmark(const SideScanLandmark& landmark) {
  reserve(landmarks_ + 1);
  const Eigen::Index at = size();
  const Eigen::Matrix<double, 3, kVehicle> JP = landmark.J_vehicle * vehicle_covariance();
  mean_.segment<3>(at) = landmark.map_p_landmark;
  P_.block<3, kVehicle>(at, 0) = JP;  // (F-5)
  const Eigen::Index m = at - kVehicle;
  P_.block(at, kVehicle, 3, m).noalias() = landmark.J_vehicle * P_.block(kVehicle, 0, m, kVehicle).transpose();
  P_.block<3, 3>(at, at) = JP * landmark.J_vehicle.transpose() + landmark.noise;
  ++landmarks_;
  if (watcher_ != nullptr) watcher_->on_add(landmark.J_vehicle);
}

void LevelledFilter::fill_columns(const StateRows& rows, Eigen::Ref<Eigen::MatrixXd> PHt) const {
  const Eigen::Index n = size();
  const Eigen::Index m = n - kVehicle;
  PHt.topRows<kVehicle>().noalias() = P_.topLeftCorner<kVehicle, kVehicle>().selfadjointView<Eigen::Lower>() * rows.vehicle.H.transpose();
  PHt.bottomRows(m).noalias() = P_.block(kVehicle, 0, m, kVehicle) * rows.vehicle.H.transpose();
  if (rows.landmark == StateRows::kNoLandmark) return;
  const Eigen::Index at = offset(rows.landmark);
  const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> Ht = rows.H_landmark.transpose();
  const Eigen::Matrix3d own = P_.block<3, 3>(at, at).selfadjointView<Eigen::Lower>();
  PHt.topRows(at).noalias() += P_.block(at, 0, 3, at).transpose() * Ht;
  PHt.middleRows<3>(at) += own * Ht;
  PHt.bottomRows(n - at - 3).noalias() += P_.block(at + 3, at, n - at - 3, 3) * Ht;
}

Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> LevelledFilter::predicted_covariance(const StateRows& a,
                                                                                                    const StateRows& b) const {
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
  // rows of P H_b' over the vehicle and over the landmark of a: the only ones that H_a reads
  const bool b_sees = b.landmark != StateRows::kNoLandmark;
  Eigen::Matrix<double, kVehicle, Eigen::Dynamic, 0, kVehicle, 3> of_vehicle(kVehicle, b.rows());
  of_vehicle.noalias() = P_.topLeftCorner<kVehicle, kVehicle>().selfadjointView<Eigen::Lower>() * b.vehicle.H.transpose();
  if (b_sees) of_vehicle.noalias() += P_.block<3, kVehicle>(offset(b.landmark), 0).transpose() * b.H_landmark.transpose();
  Small HPHt(a.rows(), b.rows());
  HPHt.noalias() = a.vehicle.H * of_vehicle;
  if (a.landmark == StateRows::kNoLandmark) return HPHt;
  const Eigen::Index at = offset(a.landmark);
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> of_landmark(3, b.rows());
  of_landmark.noalias() = P_.block<3, kVehicle>(at, 0) * b.vehicle.H.transpose();
  if (b_sees) {
    const Eigen::Index other = offset(b.landmark);
    Eigen::Matrix3d P_ab;
    if (at > other) {
      P_ab = P_.block<3, 3>(at, other);
    } else if (at < other) {
      P_ab = P_.block<3, 3>(other, at).transpose();
    } else {
      P_ab = P_.block<3, 3>(at, at).selfadjointView<Eigen::Lower>();
    }
    of_landmark.noalias() += P_ab * b.H_landmark.transpose();
  }
  HPHt.noalias() += a.H_landmark * of_landmark;
  return HPHt;
}

double LevelledFilter::squared_distance(const StateRows& rows) const {
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3> S = predicted_covariance(rows, rows) + rows.vehicle.R;
  return rows.vehicle.residual.dot(S.llt().solve(rows.vehicle.residual));
}

UpdateResult LevelledFilter::update(const std::vector<StateRows>& rows) {
  if (rows.empty()) return {};
  Eigen::Index k = 0;
  for (const StateRows& block : rows) k += block.rows();
  if (k > S_.cols()) {
    S_.resize(2 * k, 2 * k);
    innovation_.resize(2 * k);
    PHt_.resize(P_.rows(), 2 * k);
    downdate_.reserve(P_.rows(), 2 * k);
  }
  const Eigen::Index n = size();
  auto PHt = PHt_.topLeftCorner(n, k);
  auto S = S_.topLeftCorner(k, k);
  Eigen::Index j = 0;
  for (const StateRows& block : rows) {
    fill_columns(block, PHt.middleCols(j, block.rows()));
    innovation_.segment(j, block.rows()) = block.vehicle.residual;
    j += block.rows();
  }
  Eigen::Index i = 0;
  for (const StateRows& block : rows) {  // (F-3)
    S.middleRows(i, block.rows()).noalias() = block.vehicle.H * PHt.topRows<kVehicle>();
    if (block.landmark != StateRows::kNoLandmark)
      S.middleRows(i, block.rows()).noalias() += block.H_landmark * PHt.middleRows<3>(offset(block.landmark));
    S.block(i, i, block.rows(), block.rows()) += block.vehicle.R;
    i += block.rows();
  }
  const auto block_of = [&](Eigen::Index row) {
    std::size_t b = 0;
    for (; row >= rows[b].rows(); ++b) row -= rows[b].rows();
    return b;
  };
  if (const auto failed = whiten(S, PHt, innovation_.head(k))) {
    throw NotPositiveDefinite("innovation covariance", name_of(rows[block_of(*failed)]));
  }
  UpdateResult result{0.0, static_cast<int>(k)};
  for (Eigen::Index r = 0; r < k; ++r) {
    if (!std::isfinite(innovation_(r)))
      throw InvalidArgument("residual of " + name_of(rows[block_of(r)]), innovation_(r), "must be finite");
    result.nis += innovation_(r) * innovation_(r);
  }
  mean_.head(n).noalias() += PHt * innovation_.head(k);  // (F-4)
  downdate_(PHt, P_);
  wrap_vehicle(mean_.head<kVehicle>());
  if (watcher_ != nullptr) watcher_->on_update(rows, PHt, S);
  return result;
}

void LevelledFilter::archive(Archive& a) {
  Eigen::VectorXd mean = mean_.head(size());
  Eigen::MatrixXd P = P_.topLeftCorner(size(), size()).triangularView<Eigen::Lower>();  // above it nothing has a meaning
  a("landmarks", landmarks_);
  a("mean", mean);
  a("P", P);
  if (!a.reading()) return;
  a.require(landmarks_ >= 0 && landmarks_ <= mean.size() && mean.size() == size() && P.rows() == size() && P.cols() == size(),
            "has a mean and a covariance of another size");
  reserve(landmarks_);
  mean_.head(size()) = mean;
  P_.topLeftCorner(size(), size()) = P;
}

}  // namespace ssjs
