#include "ssjs/mapping/trajectory_journal.hpp"

#include <Eigen/Cholesky>
#include <utility>

#include "ssjs/base/error.hpp"

namespace ssjs {
namespace {

using ConstMap = Eigen::Map<const Eigen::MatrixXd>;

constexpr double kExitVariance = 1e-12;  // as in the joining layer: a vehicle that hardly moved

/// F' Lambda of the vehicle rows.
void pass_back(const Eigen::Vector2d& lever, Eigen::Matrix3d& vehicle) {
  vehicle.row(2) += lever.x() * vehicle.row(0) + lever.y() * vehicle.row(1);
}

}  // namespace

void TrajectoryJournal::clear() {
  entries_.clear();
  numbers_.clear();
  observations_.clear();
  steps_.clear();
  steps_.reserve(expected_steps_);
  lever_.setZero();
  snapshot_due_ = true;
}

void TrajectoryJournal::push(Entry entry) {
  entry.lever = lever_;
  lever_.setZero();
  entries_.push_back(entry);
}

void TrajectoryJournal::store(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  for (Eigen::Index c = 0; c < matrix.cols(); ++c)
    numbers_.insert(numbers_.end(), matrix.col(c).data(), matrix.col(c).data() + matrix.rows());
}

void TrajectoryJournal::on_predict(const Eigen::Matrix3d& F) {
  const bool is_shear =
      F(0, 0) == 1.0 && F(1, 0) == 0.0 && F(2, 0) == 0.0 && F(0, 1) == 0.0 && F(1, 1) == 1.0 && F(2, 1) == 0.0 && F(2, 2) == 1.0;
  if (!is_shear) throw InvalidArgument("MotionPrediction.F", "another matrix", "must be [1 0 a; 0 1 b; 0 0 1]: a motion of the plane");
  lever_ += F.topRightCorner<2, 1>();
}

void TrajectoryJournal::on_update(const std::vector<LinearObservation>& observations, const Eigen::Ref<const Eigen::MatrixXd>& Y,
                                  const Eigen::Ref<const Eigen::MatrixXd>& L, const Eigen::Ref<const Eigen::VectorXd>& t) {
  Entry entry;
  entry.kind = Kind::kUpdate;
  entry.data = numbers_.size();
  entry.rows = Y.rows();
  entry.columns = Y.cols();
  entry.observation = observations_.size();
  store(Y);
  store(L);
  store(t);
  observations_.insert(observations_.end(), observations.begin(), observations.end());
  push(entry);
  snapshot_due_ = true;
}

void TrajectoryJournal::on_add(const Eigen::Matrix<double, 2, 3>& J_vehicle) {
  Entry entry;
  entry.kind = Kind::kAdd;
  entry.data = numbers_.size();
  store(J_vehicle);
  push(entry);
  snapshot_due_ = true;
}

void TrajectoryJournal::on_remove(Eigen::Index landmark, Eigen::Index last) {
  Entry entry;
  entry.kind = Kind::kRemove;
  entry.landmark = landmark;
  entry.columns = last;
  push(entry);
  snapshot_due_ = true;
}

void TrajectoryJournal::step(double time_s, Ekf& filter) {
  const Eigen::Matrix3d covariance = filter.vehicle_covariance();
  steps_.push_back({time_s, filter.vehicle_pose(), covariance, Eigen::Matrix3d::Zero(), covariance});
  Entry entry;
  if (snapshot_due_) {
    entry.has_snapshot = true;
    entry.data = numbers_.size();
    const auto cross = filter.landmark_vehicle_covariance();
    entry.rows = cross.rows();
    store(cross);
    snapshot_due_ = false;
  }
  push(entry);
}

std::vector<SubmapStep> TrajectoryJournal::take_unconditioned_steps() {
  expected_steps_ = steps_.size();
  return std::move(steps_);
}

std::vector<SubmapStep> TrajectoryJournal::take_steps(const GaussianSe2& base_T_exit) {
  const Eigen::LLT<Eigen::Matrix3d> exit(base_T_exit.covariance + kExitVariance * Eigen::Matrix3d::Identity());
  const Eigen::Matrix3d exit_information = exit.solve(Eigen::Matrix3d::Identity());

  // Lambda_t with Cov(e_t, e_exit) = P_t Lambda_t, from the exit backwards (C-3). Its vehicle rows and its landmark rows apart.
  Eigen::Matrix3d vehicle = Eigen::Matrix3d::Identity();
  pass_back(lever_, vehicle);  // the motion after the last entry
  Eigen::MatrixXd landmarks = Eigen::MatrixXd::Zero(0, 3);
  Eigen::Index used = 0;  // rows of `landmarks`
  const auto resize = [&](Eigen::Index rows) {
    if (rows > landmarks.rows()) landmarks.conservativeResize(2 * rows, 3);
    if (rows > used) landmarks.middleRows(used, rows - used).setZero();
    used = rows;
  };
  for (const Entry& entry : entries_) {  // the landmarks alive at the exit
    if (entry.kind == Kind::kAdd) used += 2;
    if (entry.kind == Kind::kRemove) used -= 2;
  }
  landmarks.setZero(std::max<Eigen::Index>(used, 1), 3);

  // Steps share the snapshot of the step before them that has one: P(vehicle, landmarks) moves with the transitions only.
  std::vector<std::size_t> snapshot_of;
  std::vector<Eigen::Vector2d> since_snapshot;  // levers
  for (std::size_t i = 0, snapshot = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.kind != Kind::kStep) continue;
    if (entry.has_snapshot) snapshot = i;
    snapshot_of.push_back(snapshot);
    since_snapshot.push_back(entry.has_snapshot ? Eigen::Vector2d::Zero() : Eigen::Vector2d(entry.lever + since_snapshot.back()));
  }

  std::size_t step = steps_.size();
  std::size_t cross_of = entries_.size();  // the snapshot that `cross` belongs to
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t i = entries_.size(); i-- > 0;) {
    const Entry& entry = entries_[i];
    switch (entry.kind) {
      case Kind::kStep: {
        --step;
        if (cross_of != snapshot_of[step]) {
          cross_of = snapshot_of[step];
          const Entry& snapshot = entries_[cross_of];
          const ConstMap P_landmark_vehicle(numbers_.data() + snapshot.data, snapshot.rows, 3);
          cross = P_landmark_vehicle.transpose() * landmarks.topRows(snapshot.rows);
        }
        SubmapStep& at = steps_[step];
        Eigen::Matrix3d with_exit = at.covariance.lazyProduct(vehicle);  // Cov(e_t, e_exit)
        with_exit += cross;
        with_exit.topRows<2>() += since_snapshot[step].lazyProduct(cross.row(2));
        at.exit_gain = with_exit.lazyProduct(exit_information);  // (C-4)
        for (Eigen::Index c = 0; c < 3; ++c) {
          for (Eigen::Index r = c; r < 3; ++r) {
            at.conditional_covariance(r, c) = at.conditional_covariance(c, r) =
                at.covariance(r, c) - at.exit_gain.row(r).dot(with_exit.row(c));
          }
        }
        break;
      }
      case Kind::kUpdate: {  // Lambda <- (I - K H)' (I + h t') Lambda
        const ConstMap Y(numbers_.data() + entry.data, entry.rows, entry.columns);
        const ConstMap L(Y.data() + Y.size(), entry.columns, entry.columns);
        const ConstMap t(L.data() + L.size(), entry.rows, 1);
        vehicle.row(2) +=
            (t.topRows<3>().transpose() * vehicle + t.bottomRows(entry.rows - 3).transpose() * landmarks.topRows(entry.rows - 3)).eval();
        Eigen::MatrixXd KtLambda = Y.topRows<3>().transpose() * vehicle;
        KtLambda.noalias() += Y.bottomRows(entry.rows - 3).transpose() * landmarks.topRows(entry.rows - 3);
        L.triangularView<Eigen::Lower>().transpose().solveInPlace(KtLambda);
        for (Eigen::Index k = 0; k < entry.columns; k += 2) {
          const LinearObservation& z = observations_[entry.observation + static_cast<std::size_t>(k / 2)];
          vehicle.noalias() -= z.H_vehicle.transpose() * KtLambda.middleRows<2>(k);
          landmarks.middleRows<2>(2 * z.landmark).noalias() -= z.H_landmark.transpose() * KtLambda.middleRows<2>(k);
        }
        break;
      }
      case Kind::kAdd: {
        const ConstMap J_vehicle(numbers_.data() + entry.data, 2, 3);
        vehicle.noalias() += J_vehicle.transpose() * landmarks.middleRows<2>(used - 2);
        used -= 2;
        break;
      }
      case Kind::kRemove: {
        resize(used + 2);
        if (entry.landmark != entry.columns) {
          landmarks.middleRows<2>(2 * entry.columns) = landmarks.middleRows<2>(2 * entry.landmark).eval();
          landmarks.middleRows<2>(2 * entry.landmark).setZero();
        }
        break;
      }
    }
    pass_back(entry.lever, vehicle);
  }
  return take_unconditioned_steps();
}

}  // namespace ssjs
