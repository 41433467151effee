#include "ssjs/filter/ekf.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>

#include "ssjs/base/error.hpp"
#include "ssjs/filter/whitening.hpp"
#include "ssjs/sensors/range_bearing.hpp"

namespace ssjs {
namespace {

constexpr Eigen::Index kInitialObservations = 32;  // of one stacked update; more is a one-time growth
constexpr Eigen::Index kVehicle = StateLayout::kVehicle;

}  // namespace

Ekf::Ekf(Eigen::Index landmark_capacity, ErrorForm error_form, StateLayout layout) : error_form_(error_form), layout_(layout) {
  if (layout.has_frozen_pose && error_form != ErrorForm::kAdditive) {
    throw InvalidArgument("Ekf error_form", "kInvariant", "a filter with a frozen pose takes the additive form");
  }
  observations_.reserve(static_cast<std::size_t>(kInitialObservations));
  S_.resize(2 * kInitialObservations, 2 * kInitialObservations);
  innovation_.resize(2 * kInitialObservations);
  reserve(std::max<Eigen::Index>(landmark_capacity, 1));
}

void Ekf::reserve(Eigen::Index landmarks) {
  if (landmarks <= capacity_) return;
  capacity_ = std::max(landmarks, 2 * capacity_);
  const Eigen::Index n = (layout_.size(capacity_) + 3) / 4 * 4;  // whole tiles of SymmetricDowndate
  const Eigen::Index old = P_.rows();
  mean_.conservativeResize(n);
  P_.conservativeResize(n, n);
  P_.bottomRows(n - old).setZero();
  P_.rightCols(n - old).setZero();
  PHt_.resize(n, S_.cols());
  landmark_columns_.resize(n, 2);
  step_.resize(n);
  transport_.setZero(n);
  heading_column_.resize(n);
  downdate_.reserve(n, S_.cols());
}

void Ekf::reset(const GaussianSe2& submap_T_vehicle) {
  landmarks_ = 0;
  vehicle_ = submap_T_vehicle.mean;
  P_.topLeftCorner<kVehicle, kVehicle>() = submap_T_vehicle.covariance;
  if (layout_.has_frozen_pose) {  // (F-9): a second name for the vehicle of this moment
    mean_.segment<kVehicle>(kVehicle) = submap_T_vehicle.mean.vector();
    P_.block<kVehicle, kVehicle>(kVehicle, 0) = submap_T_vehicle.covariance;
    P_.block<kVehicle, kVehicle>(kVehicle, kVehicle) = submap_T_vehicle.covariance;
  }
  transition_.setIdentity();
  transition_pending_ = false;
}

void Ekf::restore(const MapState& state) {
  if (state.layout.has_frozen_pose != layout_.has_frozen_pose) {
    throw InvalidArgument("MapState.layout.has_frozen_pose", state.layout.has_frozen_pose ? "true" : "false", "must be that of the filter");
  }
  reserve(state.landmarks());
  landmarks_ = state.landmarks();
  vehicle_ = Se2::from_vector(state.mean.head<kVehicle>());
  mean_.head(state.mean.size()) = state.mean;
  P_.topLeftCorner(state.mean.size(), state.mean.size()) = state.covariance;
  transition_.setIdentity();
  transition_pending_ = false;
}

void Ekf::predict(const MotionPrediction& motion) {
  const Eigen::Matrix3d P_vehicle = vehicle_covariance();
  vehicle_ = motion.submap_T_vehicle;
  P_.topLeftCorner<kVehicle, kVehicle>() = motion.F * P_vehicle * motion.F.transpose() + motion.Q;  // (F-1)
  transition_ = motion.F * transition_;
  transition_pending_ = true;
  if (watcher_ != nullptr) watcher_->on_predict(motion.F);
}

void Ekf::settle() {
  if (!transition_pending_) return;
  const Eigen::Index m = layout_.size(landmarks_) - kVehicle;
  auto cross = P_.block(kVehicle, 0, m, kVehicle);  // P(landmarks, vehicle)
  for (Eigen::Index r = 0; r < m; ++r) {
    const Eigen::Vector3d row = transition_ * cross.row(r).transpose();  // (F-1), cross rows
    cross.row(r) = row.transpose();
  }
  transition_.setIdentity();
  transition_pending_ = false;
}

void Ekf::add_landmark(const Feature& feature) {
  const LandmarkFromRangeBearing seen = landmark_from_range_bearing(vehicle_, feature.range_bearing);
  add_landmark(seen.submap_p_landmark, seen.J_vehicle, seen.J_measurement * feature.covariance * seen.J_measurement.transpose());
}

void Ekf::add_landmark(const Eigen::Vector2d& submap_p_landmark, const Eigen::Matrix<double, 2, 3>& J_vehicle,
                       const Eigen::Matrix2d& noise) {
  reserve(landmarks_ + 1);
  settle();
  const Eigen::Index at = layout_.offset(landmarks_);
  const Eigen::Matrix3d P_vehicle = vehicle_covariance();
  mean_.segment<2>(at) = submap_p_landmark;
  P_.block<2, kVehicle>(at, 0).noalias() = J_vehicle * P_vehicle;  // (F-5)
  for (Eigen::Index c = kVehicle; c < at; ++c) P_.block<2, 1>(at, c).noalias() = J_vehicle * P_.block<1, kVehicle>(c, 0).transpose();
  P_.block<2, 2>(at, at) = J_vehicle * P_vehicle * J_vehicle.transpose() + noise;
  ++landmarks_;
  if (watcher_ != nullptr) watcher_->on_add(J_vehicle);
}

void Ekf::add_dependent_landmark(const Eigen::Vector2d& submap_p_landmark,
                                 const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& J_state, const Eigen::Matrix2d& noise) {
  if (watcher_ != nullptr) throw InvalidArgument("Ekf::add_dependent_landmark", "watched filter", "a watcher cannot follow it");
  reserve(landmarks_ + 1);
  settle();
  const Eigen::Index at = layout_.offset(landmarks_);
  const Eigen::Matrix<double, 2, Eigen::Dynamic> JP = J_state * P_.topLeftCorner(at, at).selfadjointView<Eigen::Lower>();  // (F-10)
  mean_.segment<2>(at) = submap_p_landmark;
  P_.block(at, 0, 2, at) = JP;
  P_.block<2, 2>(at, at) = JP * J_state.transpose() + noise;
  ++landmarks_;
}

void Ekf::remove_landmark(Eigen::Index landmark) {
  const Eigen::Index last = landmarks_ - 1;
  if (landmark < 0 || landmark > last) throw InvalidArgument("landmark", static_cast<double>(landmark), "no landmark has this index");
  if (landmark != last) {
    settle();
    const Eigen::Index n = layout_.size(landmarks_);
    const Eigen::Index to = layout_.offset(landmark);
    const Eigen::Index from = layout_.offset(last);
    read_landmark_columns(last, n, landmark_columns_.topRows(n));  // (F-6): the rows that stay, the last ones moved
    const Eigen::Matrix2d own = landmark_columns_.block<2, 2>(from, 0);
    mean_.segment<2>(to) = mean_.segment<2>(from);
    P_.block(to, 0, 2, to) = landmark_columns_.topRows(to).transpose();
    P_.block<2, 2>(to, to) = own;
    P_.block(to + 2, to, from - to - 2, 2) = landmark_columns_.middleRows(to + 2, from - to - 2);
  }
  --landmarks_;
  if (watcher_ != nullptr) watcher_->on_remove(landmark, last);
}

void Ekf::read_landmark_columns(Eigen::Index landmark, Eigen::Index n, Eigen::Ref<Eigen::MatrixXd> columns) const {
  const Eigen::Index at = layout_.offset(landmark);
  columns.topRows(at) = P_.block(at, 0, 2, at).transpose();
  columns.middleRows(at, n - at) = P_.block(at, at, n - at, 2);
  columns(at, 1) = columns(at + 1, 0);
}

void Ekf::predict_observations(const std::vector<Eigen::Index>& landmarks, PairingProblem& problem) {
  settle();
  const auto count = static_cast<Eigen::Index>(landmarks.size());
  problem.predicted.resize(2 * count);
  problem.predicted_covariance.resize(2 * count, 2 * count);
  problem.second_component_is_angle = true;
  const Eigen::Matrix3d P_vehicle = vehicle_covariance();
  observations_.clear();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index id = landmarks[static_cast<std::size_t>(i)];
    const RangeBearingPrediction h = predict_range_bearing(vehicle_, landmark_position(id));
    problem.predicted.segment<2>(2 * i) = h.range_bearing;
    observations_.push_back({id, Eigen::Vector2d::Zero(), h.H_vehicle, h.H_landmark, Eigen::Matrix2d::Zero()});
  }
  for (Eigen::Index i = 0; i < count; ++i) {  // (F-2): H P H' by blocks, independent of the size of the map
    const LinearObservation& a = observations_[static_cast<std::size_t>(i)];
    const Eigen::Index at_a = layout_.offset(a.landmark);
    // rows of H_i P over the vehicle
    const Eigen::Matrix<double, 2, 3> HP_vehicle = a.H_vehicle * P_vehicle + a.H_landmark * P_.block<2, kVehicle>(at_a, 0);
    for (Eigen::Index j = 0; j <= i; ++j) {
      const LinearObservation& b = observations_[static_cast<std::size_t>(j)];
      const Eigen::Index at_b = layout_.offset(b.landmark);
      Eigen::Matrix2d P_ab;  // landmark-landmark block out of the lower triangle
      if (at_a > at_b) {
        P_ab = P_.block<2, 2>(at_a, at_b);
      } else if (at_a < at_b) {
        P_ab = P_.block<2, 2>(at_b, at_a).transpose();
      } else {
        P_ab = landmark_covariance(a.landmark);
      }
      const Eigen::Matrix2d HP_b = a.H_vehicle * P_.block<2, kVehicle>(at_b, 0).transpose() + a.H_landmark * P_ab;
      const Eigen::Matrix2d HPHt = HP_vehicle * b.H_vehicle.transpose() + HP_b * b.H_landmark.transpose();
      problem.predicted_covariance.block<2, 2>(2 * i, 2 * j) = HPHt;
      problem.predicted_covariance.block<2, 2>(2 * j, 2 * i) = HPHt.transpose();
    }
  }
}

UpdateResult Ekf::update(const Features& features, const std::vector<Pair>& pairs, const std::vector<Eigen::Index>& landmarks) {
  observations_.clear();
  for (const Pair& pair : pairs) {
    const Feature& feature = features[static_cast<std::size_t>(pair.observation)];
    const Eigen::Index id = landmarks[static_cast<std::size_t>(pair.prediction)];
    const RangeBearingPrediction h = predict_range_bearing(vehicle_, landmark_position(id));
    const Eigen::Vector2d residual(feature.range() - h.range_bearing.x(), angle_difference(feature.bearing(), h.range_bearing.y()));
    observations_.push_back({id, residual, h.H_vehicle, h.H_landmark, feature.covariance});
  }
  return update(observations_);
}

UpdateResult Ekf::update(const std::vector<LinearObservation>& observations) {
  if (observations.empty()) return {};
  settle();
  const Eigen::Index n = layout_.size(landmarks_);
  const Eigen::Index m = n - kVehicle;
  const auto k = static_cast<Eigen::Index>(2 * observations.size());
  if (k > S_.cols()) {  // a scan larger than any before
    S_.resize(2 * k, 2 * k);
    innovation_.resize(2 * k);
    PHt_.resize(P_.rows(), 2 * k);
    downdate_.reserve(P_.rows(), 2 * k);
  }
  const Eigen::Matrix3d P_vehicle = vehicle_covariance();
  auto PHt = PHt_.topLeftCorner(n, k);
  auto columns = landmark_columns_.topRows(n);
  for (Eigen::Index i = 0; i < k; i += 2) {
    const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
    read_landmark_columns(z.landmark, n, columns);
    auto block = PHt.middleCols<2>(i);
    block.topRows<kVehicle>().noalias() = P_vehicle * z.H_vehicle.transpose() + columns.topRows<kVehicle>() * z.H_landmark.transpose();
    for (Eigen::Index c = 0; c < 2; ++c) {
      block.col(c).tail(m) = z.H_vehicle(c, 0) * P_.col(0).segment(kVehicle, m) + z.H_vehicle(c, 1) * P_.col(1).segment(kVehicle, m) +
                             z.H_vehicle(c, 2) * P_.col(2).segment(kVehicle, m) + z.H_landmark(c, 0) * columns.col(0).tail(m) +
                             z.H_landmark(c, 1) * columns.col(1).tail(m);
    }
    innovation_.segment<2>(i) = z.residual;
  }
  auto S = S_.topLeftCorner(k, k);
  for (Eigen::Index j = 0; j < k; j += 2) {  // (F-3): S = H P H' + R, on and below the diagonal
    const Eigen::Matrix<double, kVehicle, 2> PHt_vehicle = PHt.block<kVehicle, 2>(0, j);
    for (Eigen::Index i = j; i < k; i += 2) {
      const LinearObservation& z = observations[static_cast<std::size_t>(i / 2)];
      S.block<2, 2>(i, j) = z.H_vehicle * PHt_vehicle + z.H_landmark * PHt.block<2, 2>(layout_.offset(z.landmark), j);
    }
    S.block<2, 2>(j, j) += observations[static_cast<std::size_t>(j / 2)].R;
  }
  UpdateResult result{0.0, static_cast<int>(k)};
  if (const auto failed = whiten(S, PHt, innovation_.head(k))) {
    throw NotPositiveDefinite("innovation covariance",
                              "landmark " + std::to_string(observations[static_cast<std::size_t>(*failed / 2)].landmark) + " of the map");
  }
  for (Eigen::Index j = 0; j < k; ++j) {
    if (!std::isfinite(innovation_(j))) {
      const LinearObservation& z = observations[static_cast<std::size_t>(j / 2)];
      throw InvalidArgument("residual of landmark " + std::to_string(z.landmark) + " of the map", z.residual(j % 2), "must be finite");
    }
    result.nis += innovation_(j) * innovation_(j);
  }
  auto step = step_.head(n);
  step.setZero();
  for (Eigen::Index j = 0; j < k; ++j) step += innovation_(j) * PHt.col(j);  // (F-4): Y L^-1 nu
  downdate_(PHt, P_);                                                        // (F-4): P -= Y Y'
  if (error_form_ == ErrorForm::kInvariant) {
    move_invariantly(step);
  } else {
    move_additively(step);
  }
  if (watcher_ != nullptr) watcher_->on_update(observations, PHt, S, transport_.head(n));
  return result;
}

void Ekf::move_additively(const Eigen::Ref<const Eigen::VectorXd>& step) {
  const Eigen::Vector3d vehicle_step = step.head<kVehicle>();
  vehicle_ = additive_step(vehicle_, vehicle_step);
  mean_.segment(kVehicle, step.size() - kVehicle) += step.tail(step.size() - kVehicle);
  if (layout_.has_frozen_pose) mean_(kVehicle + 2) = wrap_angle(mean_(kVehicle + 2));
}

void Ekf::move_invariantly(const Eigen::Ref<const Eigen::VectorXd>& step) {
  const Eigen::Index n = step.size();
  const double turn = step(2);
  const Se2 unit = se2_exp({1.0, 0.0, turn});
  const Eigen::Matrix2d R = unit.rotation();
  Eigen::Matrix2d V;
  V << unit.x, -unit.y, unit.y, unit.x;
  // (F-8): with xi_p = d_p - turn x p, every point p goes to Exp(turn, xi_p) p = R p + V xi_p
  const auto moved = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& d) -> Eigen::Vector2d {
    return R * p + V * Eigen::Vector2d(d.x() + turn * p.y(), d.y() - turn * p.x());
  };
  auto t = transport_.head(n);
  const auto transport = [&](Eigen::Index at, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    t.segment<2>(at) << -(to.y() - from.y()), to.x() - from.x();
  };
  const Eigen::Vector2d vehicle_from = vehicle_.translation();
  const Eigen::Vector2d vehicle_to = moved(vehicle_from, step.head<2>());
  transport(0, vehicle_from, vehicle_to);
  t(2) = 0.0;
  vehicle_ = {vehicle_to.x(), vehicle_to.y(), wrap_angle(vehicle_.heading + turn)};
  for (Eigen::Index at = kVehicle; at < n; at += 2) {
    const Eigen::Vector2d from = mean_.segment<2>(at);
    const Eigen::Vector2d to = moved(from, step.segment<2>(at));
    transport(at, from, to);
    mean_.segment<2>(at) = to;
  }
  // P <- (I + t h') P (I + h t') = P + t w' + w t' with w = P h + (h' P h / 2) t, lower triangle
  auto w = heading_column_.head(n);
  w(0) = P_(2, 0);
  w(1) = P_(2, 1);
  w.tail(n - 2) = P_.col(2).segment(2, n - 2);
  w += 0.5 * P_(2, 2) * t;
  for (Eigen::Index c = 0; c < n; ++c) {
    P_.col(c).segment(c, n - c) += w(c) * t.tail(n - c) + t(c) * w.tail(n - c);
  }
}

Eigen::Matrix3d Ekf::vehicle_covariance() const { return P_.topLeftCorner<kVehicle, kVehicle>().selfadjointView<Eigen::Lower>(); }

Eigen::Matrix2d Ekf::landmark_covariance(Eigen::Index landmark) const {
  const Eigen::Index at = layout_.offset(landmark);
  return P_.block<2, 2>(at, at).selfadjointView<Eigen::Lower>();
}

Eigen::Ref<const Eigen::MatrixXd> Ekf::landmark_vehicle_covariance() {
  settle();
  return P_.block(layout_.poses(), 0, StateLayout::kLandmark * landmarks_, kVehicle);
}

GaussianSe2 Ekf::frozen_T_vehicle() {
  settle();
  const RelativePose relative = relative_pose(Se2::from_vector(mean_.segment<kVehicle>(kVehicle)), vehicle_);
  Eigen::Matrix<double, 3, 6> J;
  J << relative.J_j, relative.J_i;
  const Matrix6d P = P_.topLeftCorner<6, 6>().selfadjointView<Eigen::Lower>();
  return {relative.i_T_j, J * P * J.transpose()};
}

MapState Ekf::state() {
  settle();
  const Eigen::Index n = layout_.size(landmarks_);
  MapState state{mean_.head(n), P_.topLeftCorner(n, n).selfadjointView<Eigen::Lower>(), layout_};
  state.mean(StateLayout::vehicle()) = vehicle_.vector();
  return state;
}

}  // namespace ssjs
