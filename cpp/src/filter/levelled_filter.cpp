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
  seen_.reserve(kInitialRows);
  reserve(3 * std::max<Eigen::Index>(landmark_capacity, 1));
}

void LevelledFilter::reserve(Eigen::Index rows) {
  if (rows <= capacity_) return;
  capacity_ = std::max(rows, 2 * capacity_);
  offsets_.reserve(static_cast<std::size_t>(capacity_ / 3 + 1));
  const Eigen::Index n = (kVehicle + capacity_ + 3) / 4 * 4;  // whole tiles of SymmetricDowndate
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
  offsets_.resize(1);
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

template <Eigen::Index Rows>
void LevelledFilter::add(const Eigen::Matrix<double, Rows, 1>& mean, const Eigen::Matrix<double, Rows, kVehicle>& J,
                         const Eigen::Matrix<double, Rows, Rows>& noise) {
  const Eigen::Index at = size();
  reserve(at - kVehicle + Rows);
  const Eigen::Matrix<double, Rows, kVehicle> JP = J * vehicle_covariance();
  mean_.segment<Rows>(at) = mean;
  P_.block<Rows, kVehicle>(at, 0) = JP;  // (F-5)
  const Eigen::Index m = at - kVehicle;
  P_.block(at, kVehicle, Rows, m).noalias() = J * P_.block(kVehicle, 0, m, kVehicle).transpose();
  P_.block<Rows, Rows>(at, at) = JP * J.transpose() + noise;
  offsets_.push_back(at + Rows);
  if (watcher_ != nullptr) watcher_->on_add(J);
}

void LevelledFilter::add_landmark(const SideScanLandmark& landmark) { add<3>(landmark.map_p_landmark, landmark.J_vehicle, landmark.noise); }

void LevelledFilter::add_landmark(const NewRay& ray) { add<6>(ray.ray, ray.J_vehicle, ray.noise); }

double LevelledFilter::inverse_depth_sigma(Eigen::Index landmark) const {
  const Eigen::Index at = offset(landmark) + 5;
  return std::sqrt(P_(at, at));
}

void LevelledFilter::cut(Eigen::Index first, Eigen::Index rows) {
  const Eigen::Index n = size();
  const Eigen::Index after = n - first - rows;
  for (Eigen::Index i = 0; i < after; ++i) mean_(first + i) = mean_(first + rows + i);
  for (Eigen::Index c = 0; c < first; ++c) {  // columns before: their rows move up; columns after: they move left as well
    for (Eigen::Index i = 0; i < after; ++i) P_(first + i, c) = P_(first + rows + i, c);
  }
  for (Eigen::Index c = 0; c < after; ++c) {
    for (Eigen::Index i = c; i < after; ++i) P_(first + i, first + c) = P_(first + rows + i, first + rows + c);
  }
}

void LevelledFilter::convert_to_point(Eigen::Index landmark) {
  const ConvertedPoint converted = to_point(ray(landmark));
  const Eigen::Index at = offset(landmark);
  const Eigen::Index n = size();
  const Eigen::Matrix<double, 6, 6> own = P_.block<6, 6>(at, at).selfadjointView<Eigen::Lower>();
  mean_.segment<3>(at) = converted.map_p_point;  // (I-8): e_l = J e_y
  for (Eigen::Index c = 0; c < at; ++c) P_.block<3, 1>(at, c) = (converted.J * P_.block<6, 1>(at, c)).eval();
  for (Eigen::Index r = at + 6; r < n; ++r) P_.block<1, 3>(r, at) = (P_.block<1, 6>(r, at) * converted.J.transpose()).eval();
  P_.block<3, 3>(at, at) = converted.J * own * converted.J.transpose();
  cut(at + 3, 3);
  for (auto i = static_cast<std::size_t>(landmark) + 1; i < offsets_.size(); ++i) offsets_[i] -= 3;
  if (watcher_ != nullptr) watcher_->on_convert(at, converted.J);
}

void LevelledFilter::drop_landmark(Eigen::Index landmark) {
  const Eigen::Index at = offset(landmark);
  const Eigen::Index rows = rows_of(landmark);
  cut(at, rows);  // (I-9)
  offsets_.erase(offsets_.begin() + landmark);
  for (auto i = static_cast<std::size_t>(landmark); i < offsets_.size(); ++i) offsets_[i] -= rows;
  if (watcher_ != nullptr) watcher_->on_drop(at, rows);
}

void LevelledFilter::fill_columns(const StateRows& rows, Eigen::Ref<Eigen::MatrixXd> PHt) const {
  const Eigen::Index n = size();
  const Eigen::Index m = n - kVehicle;
  PHt.topRows<kVehicle>().noalias() = P_.topLeftCorner<kVehicle, kVehicle>().selfadjointView<Eigen::Lower>() * rows.vehicle.H.transpose();
  PHt.bottomRows(m).noalias() = P_.block(kVehicle, 0, m, kVehicle) * rows.vehicle.H.transpose();
  if (rows.landmark == StateRows::kNoLandmark) return;
  const Eigen::Index at = offset(rows.landmark);
  add_columns(at, rows.H_landmark.transpose(), PHt);
  if (rows.is_of_ray()) add_columns(at + 3, rows.H_ray.transpose(), PHt);
}

void LevelledFilter::add_columns(Eigen::Index at, const Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>& Ht,
                                 Eigen::Ref<Eigen::MatrixXd> PHt) const {
  const Eigen::Index n = size();
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
  if (b_sees && b.is_of_ray()) of_vehicle.noalias() += P_.block<3, kVehicle>(offset(b.landmark) + 3, 0).transpose() * b.H_ray.transpose();
  Small HPHt(a.rows(), b.rows());
  HPHt.noalias() = a.vehicle.H * of_vehicle;
  if (a.landmark == StateRows::kNoLandmark) return HPHt;
  const auto own_part = [&](Eigen::Index at, const Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3>& H) {
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3> of_landmark(3, b.rows());
    of_landmark.noalias() = P_.block<3, kVehicle>(at, 0) * b.vehicle.H.transpose();
    if (b_sees) {
      of_landmark.noalias() += covariance_block(at, offset(b.landmark)) * b.H_landmark.transpose();
      if (b.is_of_ray()) of_landmark.noalias() += covariance_block(at, offset(b.landmark) + 3) * b.H_ray.transpose();
    }
    HPHt.noalias() += H * of_landmark;
  };
  own_part(offset(a.landmark), a.H_landmark);
  if (a.is_of_ray()) own_part(offset(a.landmark) + 3, a.H_ray);
  return HPHt;
}

Eigen::Matrix3d LevelledFilter::covariance_block(Eigen::Index a, Eigen::Index b) const {
  if (a > b) return P_.block<3, 3>(a, b);
  if (a < b) return P_.block<3, 3>(b, a).transpose();
  return P_.block<3, 3>(a, a).selfadjointView<Eigen::Lower>();
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
  fill_innovation(rows, PHt, S);
  Eigen::Index i = 0;
  for (const StateRows& block : rows) {  // (F-3)
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
  if (watcher_ != nullptr) {
    seen_.clear();
    for (const StateRows& block : rows) seen_.push_back(block.landmark == StateRows::kNoLandmark ? 0 : offset(block.landmark));
    watcher_->on_update(rows, seen_, PHt, S);
  }
  return result;
}

void LevelledFilter::fill_innovation(const std::vector<StateRows>& rows, const Eigen::Ref<const Eigen::MatrixXd>& PHt,
                                     Eigen::Ref<Eigen::MatrixXd> S) const {
  Eigen::Index i = 0;
  for (const StateRows& block : rows) {
    auto of_block = S.middleRows(i, block.rows());
    of_block.noalias() = block.vehicle.H * PHt.topRows<kVehicle>();
    if (block.landmark != StateRows::kNoLandmark) {
      const Eigen::Index at = offset(block.landmark);
      of_block.noalias() += block.H_landmark * PHt.middleRows<3>(at);
      if (block.is_of_ray()) of_block.noalias() += block.H_ray * PHt.middleRows<3>(at + 3);
    }
    i += block.rows();
  }
}

Eigen::MatrixXd LevelledFilter::joint_covariance(const std::vector<StateRows>& rows) const {
  Eigen::Index k = 0;
  for (const StateRows& block : rows) k += block.rows();
  Eigen::MatrixXd PHt(size(), k), S(k, k);
  Eigen::Index j = 0;
  for (const StateRows& block : rows) {
    fill_columns(block, PHt.middleCols(j, block.rows()));
    j += block.rows();
  }
  fill_innovation(rows, PHt, S);
  return S;
}

void LevelledFilter::archive(Archive& a) {
  Eigen::VectorXd mean = mean_.head(size());
  Eigen::MatrixXd P = P_.topLeftCorner(size(), size()).triangularView<Eigen::Lower>();  // above it nothing has a meaning
  std::vector<int> rays;
  for (Eigen::Index i = 0; i < landmarks(); ++i) rays.push_back(is_ray(i) ? 1 : 0);
  a("rays", rays);
  a("mean", mean);
  a("P", P);
  if (!a.reading()) return;
  offsets_.resize(1);
  for (const int is_ray : rays) offsets_.push_back(offsets_.back() + (is_ray != 0 ? 6 : 3));
  a.require(mean.size() == size() && P.rows() == size() && P.cols() == size(), "has a mean and a covariance of another size");
  reserve(size() - kVehicle);
  mean_.head(size()) = mean;
  P_.topLeftCorner(size(), size()) = P;
}

}  // namespace ssjs
