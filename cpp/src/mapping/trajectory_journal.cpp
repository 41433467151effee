#include "ssjs/mapping/trajectory_journal.hpp"

#include <Eigen/Cholesky>

namespace ssjs {
namespace {

using ConstMap = Eigen::Map<const Eigen::MatrixXd>;

constexpr double kExitVariance = 1e-12;  // as in the joining layer: a vehicle that hardly moved

}  // namespace

void TrajectoryJournal::clear() {
  entries_.clear();
  numbers_.clear();
  observations_.clear();
  steps_.clear();
  transition_.setIdentity();
  snapshot_due_ = true;
}

void TrajectoryJournal::push(Entry entry) {
  entry.transition = transition_;
  transition_.setIdentity();
  entries_.push_back(entry);
}

void TrajectoryJournal::store(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  for (Eigen::Index c = 0; c < matrix.cols(); ++c)
    numbers_.insert(numbers_.end(), matrix.col(c).data(), matrix.col(c).data() + matrix.rows());
}

void TrajectoryJournal::on_predict(const Eigen::Matrix3d& F) { transition_ = F * transition_; }

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

std::vector<SubmapStep> TrajectoryJournal::unconditioned_steps() const { return steps_; }

std::vector<SubmapStep> TrajectoryJournal::steps(const GaussianSe2& base_T_exit) const {
  std::vector<SubmapStep> conditioned = steps_;
  const Eigen::LLT<Eigen::Matrix3d> exit(base_T_exit.covariance + kExitVariance * Eigen::Matrix3d::Identity());

  // Lambda_t with Cov(e_t, e_exit) = P_t Lambda_t, from the exit backwards (C-3). Its vehicle rows and its landmark rows apart.
  Eigen::Matrix3d vehicle = transition_.transpose();  // the motion after the last entry
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
  std::vector<Eigen::Matrix3d> since_snapshot;
  for (std::size_t i = 0, snapshot = 0; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.kind != Kind::kStep) continue;
    if (entry.has_snapshot) snapshot = i;
    snapshot_of.push_back(snapshot);
    since_snapshot.push_back(entry.has_snapshot ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(entry.transition * since_snapshot.back()));
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
        SubmapStep& at = conditioned[step];
        const Eigen::Matrix3d with_exit = at.covariance * vehicle + since_snapshot[step] * cross;  // Cov(e_t, e_exit)
        at.exit_gain = exit.solve(with_exit.transpose()).transpose();                              // (C-4)
        const Eigen::Matrix3d conditional = at.covariance - at.exit_gain * with_exit.transpose();
        at.conditional_covariance = 0.5 * (conditional + conditional.transpose());
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
    vehicle = (entry.transition.transpose() * vehicle).eval();
  }
  return conditioned;
}

}  // namespace ssjs
